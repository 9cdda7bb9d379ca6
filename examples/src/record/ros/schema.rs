//! Definitions of the ROS 2 messages that are written (Humble and later), for readers without ROS.

/// A message type: fields of its own, and the types they need.
struct Type {
    name: &'static str,
    fields: &'static str,
    needs: &'static [&'static str],
}

const TYPES: [Type; 26] = [
    Type {
        name: "builtin_interfaces/Time",
        fields: "int32 sec\nuint32 nanosec",
        needs: &[],
    },
    Type {
        name: "builtin_interfaces/Duration",
        fields: "int32 sec\nuint32 nanosec",
        needs: &[],
    },
    Type {
        name: "std_msgs/Header",
        fields: "builtin_interfaces/Time stamp\nstring frame_id",
        needs: &["builtin_interfaces/Time"],
    },
    Type {
        name: "std_msgs/ColorRGBA",
        fields: "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
        needs: &[],
    },
    Type {
        name: "std_msgs/Float32",
        fields: "float32 data",
        needs: &[],
    },
    Type {
        name: "std_msgs/Int32",
        fields: "int32 data",
        needs: &[],
    },
    Type {
        name: "std_msgs/String",
        fields: "string data",
        needs: &[],
    },
    Type {
        name: "geometry_msgs/Vector3",
        fields: "float64 x\nfloat64 y\nfloat64 z",
        needs: &[],
    },
    Type {
        name: "geometry_msgs/Point",
        fields: "float64 x\nfloat64 y\nfloat64 z",
        needs: &[],
    },
    Type {
        name: "geometry_msgs/Quaternion",
        fields: "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
        needs: &[],
    },
    Type {
        name: "geometry_msgs/Pose",
        fields: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
        needs: &["geometry_msgs/Point", "geometry_msgs/Quaternion"],
    },
    Type {
        name: "geometry_msgs/PoseStamped",
        fields: "std_msgs/Header header\ngeometry_msgs/Pose pose",
        needs: &["std_msgs/Header", "geometry_msgs/Pose"],
    },
    Type {
        name: "geometry_msgs/Transform",
        fields: "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
        needs: &["geometry_msgs/Vector3", "geometry_msgs/Quaternion"],
    },
    Type {
        name: "geometry_msgs/TransformStamped",
        fields: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
        needs: &["std_msgs/Header", "geometry_msgs/Transform"],
    },
    Type {
        name: "tf2_msgs/TFMessage",
        fields: "geometry_msgs/TransformStamped[] transforms",
        needs: &["geometry_msgs/TransformStamped"],
    },
    Type {
        name: "sensor_msgs/JointState",
        fields: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
        needs: &["std_msgs/Header"],
    },
    Type {
        name: "sensor_msgs/PointField",
        fields: "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count",
        needs: &[],
    },
    Type {
        name: "sensor_msgs/PointCloud2",
        fields: "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense",
        needs: &["std_msgs/Header", "sensor_msgs/PointField"],
    },
    Type {
        name: "sensor_msgs/CompressedImage",
        fields: "std_msgs/Header header\nstring format\nuint8[] data",
        needs: &["std_msgs/Header"],
    },
    Type {
        name: "nav_msgs/MapMetaData",
        fields: "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin",
        needs: &["builtin_interfaces/Time", "geometry_msgs/Pose"],
    },
    Type {
        name: "nav_msgs/OccupancyGrid",
        fields: "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data",
        needs: &["std_msgs/Header", "nav_msgs/MapMetaData"],
    },
    Type {
        name: "nav_msgs/Path",
        fields: "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses",
        needs: &["std_msgs/Header", "geometry_msgs/PoseStamped"],
    },
    Type {
        name: "visualization_msgs/UVCoordinate",
        fields: "float32 u\nfloat32 v",
        needs: &[],
    },
    Type {
        name: "visualization_msgs/MeshFile",
        fields: "string filename\nuint8[] data",
        needs: &[],
    },
    Type {
        name: "visualization_msgs/Marker",
        fields: "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\nint32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\nstd_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\nsensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials",
        needs: &[
            "std_msgs/Header",
            "geometry_msgs/Pose",
            "geometry_msgs/Vector3",
            "std_msgs/ColorRGBA",
            "builtin_interfaces/Duration",
            "geometry_msgs/Point",
            "sensor_msgs/CompressedImage",
            "visualization_msgs/UVCoordinate",
            "visualization_msgs/MeshFile",
        ],
    },
    Type {
        name: "visualization_msgs/MarkerArray",
        fields: "visualization_msgs/Marker[] markers",
        needs: &["visualization_msgs/Marker"],
    },
];

fn find(name: &str) -> Option<&'static Type> {
    TYPES.iter().find(|t| t.name == name)
}

/// Text of a message definition with all types it needs, in the form `ros2msg`. Empty for a type that is not written.
pub(super) fn definition(name: &str) -> String {
    let mut names = vec![name];
    let mut next = 0;
    while let Some(t) = names.get(next).and_then(|n| find(n)) {
        for need in t.needs {
            if !names.contains(need) {
                names.push(need);
            }
        }
        next += 1;
    }
    let mut out = String::new();
    for t in names.iter().filter_map(|n| find(n)) {
        if !out.is_empty() {
            out.push_str(&"=".repeat(80));
            out.push_str("\nMSG: ");
            out.push_str(t.name);
            out.push('\n');
        }
        out.push_str(t.fields);
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_needed_type_is_defined_once() {
        for t in &TYPES {
            for need in t.needs {
                assert!(find(need).is_some(), "{} needs {need}", t.name);
                assert!(t.fields.contains(need));
            }
        }
        let text = definition("visualization_msgs/MarkerArray");
        assert!(text.starts_with("visualization_msgs/Marker[] markers\n===="));
        for name in ["std_msgs/Header", "geometry_msgs/Quaternion"] {
            assert_eq!(text.matches(&format!("\nMSG: {name}\n")).count(), 1);
        }
        assert_eq!(definition("std_msgs/Nothing"), "");
    }
}
