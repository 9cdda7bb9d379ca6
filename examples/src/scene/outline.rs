//! Shapes seen from above, for pictures.

use super::format::Scene;
use super::solid::{Form, Solid};

/// A solid seen from above.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOutline {
    /// Corners of a convex outline in world x, y, counter-clockwise, m.
    pub corners: Vec<[f64; 2]>,
    /// Lowest and highest point of the solid above the floor, m.
    pub band: (f64, f64),
}

impl Scene {
    /// All shapes seen from above, lowest tops first so that tall ones are drawn over them.
    pub fn outlines(&self) -> Vec<PlanOutline> {
        let mut all: Vec<_> = self
            .shapes
            .iter()
            .map(|s| Solid::new(s).outline(self.floor_z))
            .collect();
        all.sort_by(|a, b| a.band.1.total_cmp(&b.band.1));
        all
    }
}

impl Solid {
    /// The solid seen from above; cylinders become polygons of 24 corners, meshes their convex outline.
    pub fn outline(&self, floor_z: f64) -> PlanOutline {
        let points: Vec<[f64; 2]> = match &self.form {
            Form::Mesh(mesh) => mesh.vertices.iter().map(|v| [v[0], v[1]]).collect(),
            Form::Box(h) => {
                let signs =
                    (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f64::from(b) - 1.0));
                signs
                    .map(|s| self.plan([0, 1, 2].map(|k| s[k] * h[k])))
                    .collect()
            }
            Form::Cylinder(r, h) => (0..48)
                .map(|i| {
                    let (s, c) = (f64::from(i / 2) * std::f64::consts::TAU / 24.0).sin_cos();
                    self.plan([r * c, r * s, if i % 2 == 0 { *h } else { -h }])
                })
                .collect(),
        };
        PlanOutline {
            corners: hull(points),
            band: (self.low[2] - floor_z, self.high[2] - floor_z),
        }
    }

    fn plan(&self, local: [f64; 3]) -> [f64; 2] {
        [0, 1].map(|k| self.center[k] + (0..3).map(|j| self.axes[j][k] * local[j]).sum::<f64>())
    }
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|a, b| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9);
    let chain = |forward: bool| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        let mut add = |p: [f64; 2]| {
            while let [.., a, b] = out[..] {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 1e-12 {
                    break;
                }
                out.pop();
            }
            out.push(p);
        };
        if forward {
            points.iter().for_each(|&p| add(p))
        } else {
            points.iter().rev().for_each(|&p| add(p))
        }
        out.pop();
        out
    };
    let mut corners = chain(true);
    corners.extend(chain(false));
    corners
}
