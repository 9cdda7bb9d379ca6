//! Each bad input has its own error, which names the field; the embedded scenes are good.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::scene::{BUILTIN, Footprint, Scene, SceneError, Shape};

fn closet() -> Scene {
    Scene::builtin("closet").unwrap()
}

/// The message of what is wrong with the closet after a change.
fn wrong(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = closet();
    change(&mut scene);
    scene.check(&Footprint::default()).unwrap_err().to_string()
}

/// The message of what is wrong with the closet's text after a replacement.
fn misread(from: &str, to: &str) -> String {
    let text = include_str!("../scenes/closet.json");
    assert!(text.contains(from), "{from}");
    Scene::from_json(&text.replacen(from, to, 1))
        .unwrap_err()
        .to_string()
}

fn first_box(scene: &mut Scene) -> &mut seekplan::scene::BoxShape {
    scene
        .shapes
        .iter_mut()
        .find_map(|s| if let Shape::Box(b) = s { Some(b) } else { None })
        .unwrap()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(
            message.contains(part),
            "{message:?} does not mention {part:?}"
        );
    }
}

#[test]
fn embedded_scenes_load() {
    for name in BUILTIN {
        let scene = Scene::open(name).unwrap();
        // The race world is FLAP's: it has volumes to search instead of tags.
        assert!(scene.tags.len() >= 3 || name == "race", "{name}");
        assert!(!scene.outlines().is_empty());
    }
    let office = Scene::builtin("office").unwrap();
    assert_eq!((office.shapes.len(), office.tags.len()), (341, 8));
    assert_eq!(office.bounds.max, [30.0, 20.0, 3.0]);
    assert_eq!(Scene::builtin("lab").unwrap().limits.voxel, 0.1);
}

#[test]
fn a_scene_survives_writing_and_reading() {
    for name in BUILTIN {
        let scene = Scene::builtin(name).unwrap();
        assert_eq!(
            Scene::from_json(&serde_json::to_string(&scene).unwrap()).unwrap(),
            scene
        );
    }
}

#[test]
fn unknown_names_and_missing_files_are_told_apart() {
    assert!(matches!(
        Scene::open("cellar"),
        Err(SceneError::NoBuiltin { .. })
    ));
    assert!(matches!(
        Scene::open("no/such/file.json"),
        Err(SceneError::Read { .. })
    ));
}

#[test]
fn absent_limits_have_defaults() {
    let text = include_str!("../scenes/closet.json");
    let start = text.find("\"limits\"").unwrap();
    let end = start + text[start..].find('\n').unwrap();
    let scene = Scene::from_json(&format!("{}{}", &text[..start], &text[end..])).unwrap();
    assert_eq!((scene.limits.v_max, scene.limits.time_limit), (0.8, 900.0));
}

#[test]
fn grammar_errors_name_field_and_line() {
    says(
        &misread("\"floor_z\"", "\"flor_z\""),
        &["unknown field `flor_z`", "line"],
    );
    says(&misread("\"v_max\"", "\"vmax\""), &["unknown field `vmax`"]);
    says(
        &misread("\"half_extents\"", "\"extents\""),
        &["unknown field `extents`"],
    );
    says(
        &misread(
            "\"bounds\": {\"min\": [0, 0, 0], \"max\": [5.1, 4.2, 2.4]},",
            "",
        ),
        &["missing field `bounds`"],
    );
    says(&misread("\"floor_z\": 0.0", "\"floor_z\": NaN"), &["line"]);
    says(
        &misread("\"floor_z\": 0.0", "\"floor_z\": 1e999"),
        &["number out of range", "line"],
    );
    says(
        &misread("\"type\":\"box\"", "\"type\":\"cone\""),
        &["unknown variant `cone`"],
    );
    says(&misread("\"id\":0", "\"id\":-1"), &["-1"]);
    says(
        &misread("search-scene/1", "search-scene/2"),
        &["schema", "search-scene/2", "search-scene/1"],
    );
    says(
        &misread("\"length\": \"m\"", "\"length\": \"cm\""),
        &["units.length", "cm"],
    );
    says(
        &misread("\"angle\": \"rad\"", "\"angle\": \"deg\""),
        &["units.angle", "deg"],
    );
}

#[test]
fn numbers_must_be_finite() {
    says(
        &wrong(|s| s.bounds.min[1] = f64::NAN),
        &["bounds.min[1]", "NaN"],
    );
    says(&wrong(|s| s.floor_z = f64::INFINITY), &["floor_z", "inf"]);
    says(&wrong(|s| s.start.yaw = f64::NAN), &["start.yaw", "NaN"]);
    says(
        &wrong(|s| s.limits.voxel = f64::NAN),
        &["limits.voxel", "NaN"],
    );
    says(
        &wrong(|s| s.tags[1].center[2] = f64::NAN),
        &["tags[1].center[2]", "NaN"],
    );
    says(
        &wrong(|s| first_box(s).center[0] = f64::NAN),
        &["shapes[0]", "center[0]", "NaN"],
    );
    says(
        &wrong(|s| first_box(s).yaw = Some(f64::NAN)),
        &["shapes[0]", "yaw", "NaN"],
    );
}

#[test]
fn sizes_must_be_positive() {
    says(
        &wrong(|s| first_box(s).half_extents[2] = -0.5),
        &["shapes[0]", "wall_00.s", "half_extents[2]", "-0.5"],
    );
    says(
        &wrong(|s| first_box(s).half_extents[1] = 0.0),
        &["half_extents[1] = 0 must be positive"],
    );
    says(&wrong(|s| s.tags[2].size = -0.2), &["tags[2].size", "-0.2"]);
    says(&wrong(|s| s.limits.v_max = 0.0), &["limits.v_max"]);
    let can = |s: &mut Scene, change: fn(&mut seekplan::scene::CylinderShape)| {
        s.shapes.iter_mut().for_each(|s| {
            if let Shape::Cylinder(c) = s {
                change(c)
            }
        });
    };
    says(
        &wrong(|s| can(s, |c| c.radius = -1.0)),
        &["bin.body", "radius", "-1"],
    );
    says(
        &wrong(|s| can(s, |c| c.half_height = 0.0)),
        &["bin.body", "half_height"],
    );
}

#[test]
fn ranges_must_not_be_empty() {
    says(
        &wrong(|s| s.bounds.max[2] = 0.0),
        &["bounds axis 2", "0 must be below 0"],
    );
    says(
        &wrong(|s| s.ceiling_z = Some(-1.0)),
        &["floor_z..ceiling_z", "-1"],
    );
    says(
        &wrong(|s| s.rooms[0].min[0] = 9.0),
        &["rooms[0] axis 0", "9"],
    );
}

#[test]
fn the_start_must_be_free_and_inside() {
    says(
        &wrong(|s| s.start.x = 7.0),
        &["start", "7", "outside bounds"],
    );
    // Its nose reaches the cabinet's face at x = 4.35.
    says(
        &wrong(|s| (s.start.x, s.start.y) = (4.0, 1.2)),
        &["start = (4, 1.2, 0)", "cabinet.body"],
    );
    // Half a turn of the same footprint fits lengthwise only.
    says(
        &wrong(|s| (s.start.x, s.start.yaw) = (0.5, 0.0)),
        &["wall_02.w"],
    );
    let mut scene = closet();
    (scene.start.x, scene.start.yaw) = (0.5, std::f64::consts::FRAC_PI_2);
    assert!(scene.check(&Footprint::default()).is_ok());
    // A robot of another size is judged by its own footprint.
    scene.start.yaw = 0.0;
    assert!(
        scene
            .check(&Footprint {
                half: [0.2, 0.2],
                band: (0.0, 0.4)
            })
            .is_ok()
    );
}

#[test]
fn tags_must_be_visible_from_somewhere() {
    says(
        &wrong(|s| s.tags[0].center = [4.65, 1.2, 0.5]),
        &["tags[0].center", "cabinet.body"],
    );
    says(
        &wrong(|s| s.tags[0].center = [4.6, 2.4, 0.2]),
        &["tags[0]", "bin.body"],
    );
    says(
        &wrong(|s| s.tags[0].center[0] = 5.5),
        &["tags[0].center", "outside bounds"],
    );
    says(&wrong(|s| s.floor_z = 0.5), &["tags[2]", "floor"]);
}

#[test]
fn tag_axes_must_be_unit_and_orthogonal() {
    says(
        &wrong(|s| s.tags[0].normal = [0.0, 2.0, 0.0]),
        &["tags[0].normal", "2"],
    );
    says(
        &wrong(|s| s.tags[0].up = [0.0, 0.0, 0.5]),
        &["tags[0].up", "0.5"],
    );
    says(
        &wrong(|s| s.tags[0].up = [0.0, 1.0, 0.0]),
        &["tags[0].up is not orthogonal", "1"],
    );
    says(&wrong(|s| s.tags[2].id = 0), &["tags[2].id = 0", "taken"]);
}

#[test]
fn rotations_must_be_unambiguous() {
    let quat = Some([1.0, 0.0, 0.0, 0.0]);
    says(
        &wrong(|s| (first_box(s).yaw, first_box(s).quat) = (Some(0.1), quat)),
        &["wall_00.s", "both yaw and quat"],
    );
    says(
        &wrong(|s| first_box(s).quat = Some([0.0; 4])),
        &["wall_00.s", "quat", "length 0"],
    );
}

#[test]
fn meshes_must_hold_together() {
    let mesh = |triangles| {
        Shape::Mesh(seekplan::scene::MeshShape {
            name: "tent.m".into(),
            vertices: vec![[1.0, 3.0, 0.0], [1.0, 3.4, 0.0], [1.2, 3.2, 0.5]],
            triangles,
        })
    };
    says(
        &wrong(|s| s.shapes.push(mesh(vec![]))),
        &["shapes[12]", "tent.m", "empty mesh"],
    );
    says(
        &wrong(|s| s.shapes.push(mesh(vec![[0, 1, 3]]))),
        &["tent.m", "triangles[0]", "vertex 3 of 3"],
    );
    says(
        &wrong(|s| {
            s.shapes.push(mesh(vec![[0, 1, 2]]));
            if let Some(Shape::Mesh(m)) = s.shapes.last_mut() {
                m.vertices[2][1] = f64::NAN;
            }
        }),
        &["vertices[2]", "NaN"],
    );
}
