//! What a scene must fulfil beyond its grammar.

use super::SceneError as Error;
use super::format::{Scene, Shape};
use super::solid::{Solid, dot, pose, vec3};
use parry3d::query::intersection_test;
use parry3d::shape::Cuboid;

/// How far a quaternion or direction may be off unit length: files carry six digits or fewer.
const UNIT: f64 = 1e-3;
/// A tag is tested this far in front of its face, m.
const TAG_OFFSET: f64 = 0.002;

/// The box of the robot's base, for the test that the start is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Half the length and half the width, m.
    pub half: [f64; 2],
    /// Height band above the floor, m.
    pub band: (f64, f64),
}

impl Default for Footprint {
    /// 0.75 x 0.55 m, 0.40 m high.
    fn default() -> Self {
        Self {
            half: [0.375, 0.275],
            band: (0.0, 0.40),
        }
    }
}

fn finite(field: impl Fn() -> String, value: f64) -> Result<(), Error> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(Error::NotFinite {
            field: field(),
            value,
        })
    }
}

fn finites(field: impl Fn() -> String, values: &[f64]) -> Result<(), Error> {
    for (k, &value) in values.iter().enumerate() {
        finite(|| format!("{}[{k}]", field()), value)?;
    }
    Ok(())
}

fn positive(field: impl Fn() -> String, value: f64) -> Result<(), Error> {
    finite(&field, value)?;
    if value > 0.0 {
        Ok(())
    } else {
        Err(Error::NotPositive {
            field: field(),
            value,
        })
    }
}

fn ranges(field: impl Fn() -> String, low: &[f64], high: &[f64]) -> Result<(), Error> {
    finites(|| format!("{}.min", field()), low)?;
    finites(|| format!("{}.max", field()), high)?;
    for (k, (&low, &high)) in low.iter().zip(high).enumerate() {
        if low >= high {
            return Err(Error::EmptyRange {
                field: format!("{} axis {k}", field()),
                low,
                high,
            });
        }
    }
    Ok(())
}

fn unit(field: impl Fn() -> String, values: &[f64]) -> Result<(), Error> {
    finites(&field, values)?;
    let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    if (length - 1.0).abs() <= UNIT {
        Ok(())
    } else {
        Err(Error::NotUnit {
            field: field(),
            length,
        })
    }
}

impl Scene {
    /// Checks everything a simulator relies on.
    ///
    /// # Errors
    /// The first thing found wrong, by field.
    pub fn check(&self, footprint: &Footprint) -> Result<(), Error> {
        self.check_header()?;
        for (i, shape) in self.shapes.iter().enumerate() {
            check_shape(i, shape)?;
        }
        let solids: Vec<Solid> = self.shapes.iter().map(Solid::new).collect();
        self.check_tags(&solids)?;
        self.check_start(footprint, &solids)
    }

    fn check_header(&self) -> Result<(), Error> {
        for (field, found, expected) in [
            ("schema", &self.schema, "search-scene/1"),
            ("units.length", &self.units.length, "m"),
            ("units.angle", &self.units.angle, "rad"),
        ] {
            if found != expected {
                return Err(Error::Text {
                    field,
                    found: found.clone(),
                    expected,
                });
            }
        }
        ranges(|| "bounds".into(), &self.bounds.min, &self.bounds.max)?;
        finite(|| "floor_z".into(), self.floor_z)?;
        if let Some(high) = self.ceiling_z {
            finite(|| "ceiling_z".into(), high)?;
            if high <= self.floor_z {
                let field = "floor_z..ceiling_z".into();
                return Err(Error::EmptyRange {
                    field,
                    low: self.floor_z,
                    high,
                });
            }
        }
        let l = &self.limits;
        for (name, value) in [
            ("v_max", l.v_max),
            ("w_max", l.w_max),
            ("joint_v_max", l.joint_v_max),
            ("d_ins", l.d_ins),
            ("voxel", l.voxel),
            ("time_limit", l.time_limit),
        ] {
            positive(|| format!("limits.{name}"), value)?;
        }
        for (i, room) in self.rooms.iter().enumerate() {
            ranges(|| format!("rooms[{i}]"), &room.min, &room.max)?;
        }
        for (i, volume) in self.target_volumes.iter().enumerate() {
            ranges(|| format!("target_volumes[{i}]"), &volume.min, &volume.max)?;
            if !(0.0..=1.0).contains(&volume.p) {
                let field = format!("target_volumes[{i}].p");
                return Err(Error::NotAShare {
                    field,
                    value: volume.p,
                });
            }
        }
        Ok(())
    }

    fn outside(&self, field: String, point: &[f64]) -> Result<(), Error> {
        let (low, high) = (self.bounds.min, self.bounds.max);
        if point
            .iter()
            .enumerate()
            .all(|(k, &v)| v >= low[k] && v <= high[k])
        {
            return Ok(());
        }
        Err(Error::OutsideBounds {
            field,
            point: point.to_vec(),
            low,
            high,
        })
    }

    fn check_tags(&self, solids: &[Solid]) -> Result<(), Error> {
        for (index, tag) in self.tags.iter().enumerate() {
            let id = tag.id;
            if self.tags[..index].iter().any(|t| t.id == id) {
                return Err(Error::DuplicateId { index, id });
            }
            finites(|| format!("tags[{index}].center"), &tag.center)?;
            positive(|| format!("tags[{index}].size"), tag.size)?;
            unit(|| format!("tags[{index}].normal"), &tag.normal)?;
            unit(|| format!("tags[{index}].up"), &tag.up)?;
            let turn = dot(tag.normal, tag.up);
            if turn.abs() > UNIT {
                return Err(Error::NotOrthogonal { index, dot: turn });
            }
            self.outside(format!("tags[{index}].center"), &tag.center)?;
            let front = [0, 1, 2].map(|k| tag.center[k] + TAG_OFFSET * tag.normal[k]);
            let shape = if front[2] < self.floor_z {
                Some("floor")
            } else if self.ceiling_z.is_some_and(|z| front[2] > z) {
                Some("ceiling")
            } else {
                solids
                    .iter()
                    .find(|s| s.contains(front))
                    .map(|s| s.name.as_str())
            };
            if let Some(shape) = shape {
                let (center, shape) = (tag.center, shape.to_owned());
                return Err(Error::TagInside {
                    index,
                    id,
                    center,
                    shape,
                });
            }
        }
        Ok(())
    }

    fn check_start(&self, footprint: &Footprint, solids: &[Solid]) -> Result<(), Error> {
        let (x, y, yaw) = (self.start.x, self.start.y, self.start.yaw);
        for (name, value) in [("x", x), ("y", y), ("yaw", yaw)] {
            finite(|| format!("start.{name}"), value)?;
        }
        self.outside("start".into(), &[x, y])?;
        let (s, c) = yaw.sin_cos();
        let (low, high) = footprint.band;
        let base = pose(
            &[[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]],
            [x, y, self.floor_z + 0.5 * (low + high)],
        );
        let base_box = Cuboid::new(vec3([
            footprint.half[0],
            footprint.half[1],
            0.5 * (high - low),
        ]));
        for solid in solids {
            let (shape, at) = solid.parry();
            if intersection_test(&base, &base_box, at, shape.as_ref()).is_ok_and(|m| m.intersecting)
            {
                return Err(Error::StartBlocked {
                    x,
                    y,
                    yaw,
                    shape: solid.name.clone(),
                });
            }
        }
        Ok(())
    }
}

fn check_shape(index: usize, shape: &Shape) -> Result<(), Error> {
    let field = |part: &str| format!("shapes[{index}] {:?} {part}", shape.name());
    match shape {
        Shape::Box(s) => {
            finites(|| field("center"), &s.center)?;
            for (k, &h) in s.half_extents.iter().enumerate() {
                positive(|| field(&format!("half_extents[{k}]")), h)?;
            }
            finite(|| field("yaw"), s.yaw.unwrap_or(0.0))?;
            if s.yaw.is_some() && s.quat.is_some() {
                return Err(Error::TwoRotations {
                    index,
                    name: s.name.clone(),
                });
            }
            s.quat.map_or(Ok(()), |q| unit(|| field("quat"), &q))
        }
        Shape::Cylinder(s) => {
            finites(|| field("center"), &s.center)?;
            positive(|| field("radius"), s.radius)?;
            positive(|| field("half_height"), s.half_height)?;
            s.quat.map_or(Ok(()), |q| unit(|| field("quat"), &q))
        }
        Shape::Mesh(s) => {
            for (i, v) in s.vertices.iter().enumerate() {
                finites(|| field(&format!("vertices[{i}]")), v)?;
            }
            if s.triangles.is_empty() {
                return Err(Error::EmptyMesh {
                    index,
                    name: s.name.clone(),
                });
            }
            for (i, t) in s.triangles.iter().enumerate() {
                if let Some(&vertex) = t.iter().find(|&&v| v as usize >= s.vertices.len()) {
                    return Err(Error::MeshIndex {
                        index,
                        name: s.name.clone(),
                        triangle: i,
                        vertex,
                        vertices: s.vertices.len(),
                    });
                }
            }
            Ok(())
        }
    }
}
