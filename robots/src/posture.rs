//! Camera postures: arm states that look ahead of the base from a given height at a given elevation.

use crate::error::Error;
use crate::frame::{Frame, V3, add, cross, dot, scale, sub};
use crate::ik::wrap;
use crate::manipulator::{BodyState, MobileManipulator};
use crate::view::{CameraSolution, SELF_MARGIN};

/// What the camera of a posture should see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Height of the lens above the floor, m.
    pub height: f64,
    /// Elevation of the optical axis, rad; up is positive.
    pub pitch: f64,
}

/// An arm state that holds the camera level in roll, looking along the base's x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// What was asked for.
    pub view: View,
    /// Joint angles, rad.
    pub joints: [f64; 6],
    /// base_from_camera, optical frame.
    pub camera: Frame,
    /// Greatest horizontal distance of the arm's spheres from the base's turning centre, m.
    pub reach: f64,
    /// How far the arm's spheres stand out beyond the base's rectangle, m.
    pub overhang: f64,
    /// Self-clearance, m.
    pub clearance: f64,
    /// |det J|, m^3.
    pub manipulability: f64,
    /// Share of the image that shows the robot itself.
    pub hidden: f64,
    /// Price of the posture itself, in [`PostureWeights`] units.
    pub price: f64,
}

/// What the search for postures prefers. All prices are added.
#[derive(Clone, Debug, PartialEq)]
pub struct PostureWeights {
    /// Distances of the camera ahead of the base centre: first, last and step, m.
    pub ahead: [f64; 3],
    /// Distances of the camera beside the base's middle: first, last and step, m.
    pub beside: [f64; 3],
    /// Changes of the height asked for: first, last and step, m.
    pub height: [f64; 3],
    /// Price of a metre of change of height.
    pub height_price: f64,
    /// Price of a metre of overhang beyond the base's rectangle.
    pub overhang: f64,
    /// Price of a metre of the camera's offset to the side.
    pub offset: f64,
    /// Self-clearance (m) below which each missing metre costs `clearance_price`.
    pub clearance: f64,
    /// See `clearance`.
    pub clearance_price: f64,
    /// Manipulability (m^3) below which the missing share costs `manipulability_price`.
    pub manipulability: f64,
    /// See `manipulability`.
    pub manipulability_price: f64,
    /// Price of a metre that the elbow is below the shoulder.
    pub elbow_drop: f64,
    /// Price of an image that shows nothing but the robot.
    pub hidden: f64,
    /// Price of a second that the slowest joint needs from the level posture.
    pub second: f64,
    /// Price of a radian of each joint off zero: decides between mirrored postures.
    pub turn: f64,
    /// How many times the price of the first of several postures counts: it is held most of the time.
    pub first: f64,
    /// Tangents of half the image's angles, used for `hidden`: horizontal, vertical.
    pub tan_half: [f64; 2],
}

impl Default for PostureWeights {
    fn default() -> Self {
        Self {
            ahead: [0.10, 0.70, 0.05],
            beside: [-0.30, 0.30, 0.05],
            height: [-0.20, 0.10, 0.05],
            height_price: 2.0,
            overhang: 3.0,
            offset: 0.5,
            clearance: 0.04,
            clearance_price: 60.0,
            manipulability: 0.02,
            manipulability_price: 0.5,
            elbow_drop: 2.0,
            hidden: 10.0,
            second: 1.5,
            turn: 0.01,
            first: 1.0,
            // Half of 87 and 58 degrees.
            tan_half: [0.949, 0.554],
        }
    }
}

/// The views of the default library: level; 25, 50 and 75 degrees down from 1.2, 1.3 and 1.4 m; as much up from
/// 0.8, 0.6 and 0.45 m.
#[must_use]
pub fn default_views() -> [View; 7] {
    let view = |degrees: f64, height| View {
        height,
        pitch: degrees.to_radians(),
    };
    [
        view(0.0, 1.0),
        view(-25.0, 1.2),
        view(25.0, 0.8),
        view(-50.0, 1.3),
        view(50.0, 0.6),
        view(-75.0, 1.4),
        view(75.0, 0.45),
    ]
}

/// base_from_camera (or world_from_camera) of a camera at `position` without roll, looking towards `yaw` and
/// `pitch` (rad, up is positive).
#[must_use]
pub fn looking(position: [f64; 3], yaw: f64, pitch: f64) -> Frame {
    let ((sy, cy), (sp, cp)) = (yaw.sin_cos(), pitch.sin_cos());
    let z = [cp * cy, cp * sy, sp];
    let x = [sy, -cy, 0.0];
    Frame {
        x,
        y: cross(z, x),
        z,
        p: position,
    }
}

impl MobileManipulator {
    /// Every arm state found on the grid of `weights` that shows `view`, free of self-collision; order of the grid.
    ///
    /// Joint angles are the copies nearest to `near`.
    #[must_use]
    pub fn posture_candidates(
        &self,
        view: &View,
        near: &[f64; 6],
        weights: &PostureWeights,
    ) -> Vec<Posture> {
        let mut out = Vec::new();
        let places = steps(weights.ahead)
            .flat_map(|x| steps(weights.beside).map(move |y| [x, y]))
            .flat_map(|[x, y]| steps(weights.height).map(move |dz| [x, y, dz]));
        for [x, y, dz] in places {
            let camera = looking([x, y, view.height + dz], 0.0, view.pitch);
            for s in self.ik_camera_frame([0.0; 3], &camera, near).as_slice() {
                out.push(self.measured(view, &camera, s, weights));
            }
        }
        out
    }

    /// The cheapest posture for `view`; `near` is the posture it should be quick to reach from.
    ///
    /// Joint motion in a straight line between the two is free of self-collision where any candidate offers that.
    ///
    /// # Errors
    /// If the view is not finite, or out of reach from every place of the grid.
    pub fn posture(
        &self,
        view: &View,
        near: &[f64; 6],
        weights: &PostureWeights,
    ) -> Result<Posture, Error> {
        if !(view.height.is_finite() && view.pitch.is_finite()) {
            return Err(Error::NotFinite { field: "view" });
        }
        let candidates = self.posture_candidates(view, near, weights);
        self.choose(&candidates, near, weights)
            .ok_or_else(|| no_posture(view))
    }

    /// One posture for each view, near each other: the first view's posture is the one from which the others
    /// together cost least.
    ///
    /// # Errors
    /// If there is no view, one is not finite, or one is out of reach.
    pub fn postures(
        &self,
        views: &[View],
        weights: &PostureWeights,
    ) -> Result<Vec<Posture>, Error> {
        let Some(first) = views.first() else {
            return Err(Error::NoViews);
        };
        if views
            .iter()
            .any(|v| !(v.height.is_finite() && v.pitch.is_finite()))
        {
            return Err(Error::NotFinite { field: "views" });
        }
        let sets: Vec<Vec<Posture>> = views
            .iter()
            .map(|v| self.posture_candidates(v, &[0.0; 6], weights))
            .collect();
        let mut homes: Vec<&Posture> = sets[0].iter().collect();
        homes.sort_by(|a, b| a.price.total_cmp(&b.price));
        let total = |home: &Posture| {
            let rest = sets[1..].iter().map(|set| {
                let prices = set
                    .iter()
                    .map(|p| self.price_from(p, &home.joints, weights));
                prices.fold(f64::INFINITY, f64::min)
            });
            weights.first * home.price + rest.sum::<f64>()
        };
        let best = homes
            .iter()
            .take(HOMES)
            .map(|h| (total(h), *h))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, home)) = best else {
            return Err(no_posture(first));
        };
        let mut out = vec![*home];
        for (view, set) in views.iter().zip(&sets).skip(1) {
            out.push(
                self.choose(set, &home.joints, weights)
                    .ok_or_else(|| no_posture(view))?,
            );
        }
        Ok(out)
    }

    /// [`postures`](Self::postures) for [`default_views`]; the first is the level one, compact enough to drive with.
    ///
    /// # Errors
    /// If the robot's sizes were changed so that a view is out of reach.
    pub fn default_postures(&self) -> Result<Vec<Posture>, Error> {
        self.postures(&default_views(), &PostureWeights::default())
    }

    /// Joints that bring the camera to `base_from_camera`, the cheapest by `weights` from `near`; `None` if every
    /// solution leaves the joint limits or touches the robot itself.
    #[must_use]
    pub fn reach(
        &self,
        base_from_camera: &Frame,
        near: &[f64; 6],
        weights: &PostureWeights,
    ) -> Option<[f64; 6]> {
        let view = View {
            height: base_from_camera.p[2],
            pitch: base_from_camera.z[2].clamp(-1.0, 1.0).asin(),
        };
        let found = self.ik_camera_frame([0.0; 3], base_from_camera, near);
        let mut set = [None; 8];
        for (slot, s) in set.iter_mut().zip(found.as_slice()) {
            *slot = Some(self.measured(&view, base_from_camera, s, weights));
        }
        let set: Vec<Posture> = set.into_iter().flatten().collect();
        Some(self.choose(&set, near, weights)?.joints)
    }

    fn price_from(&self, p: &Posture, near: &[f64; 6], weights: &PostureWeights) -> f64 {
        // Whole turns are taken off when the posture is chosen.
        let turn = |j: usize| wrap(p.joints[j] - near[j]).abs() / self.limits.joint_speed[j];
        p.price + weights.second * (0..6).map(turn).fold(0.0, f64::max)
    }

    fn choose(
        &self,
        set: &[Posture],
        near: &[f64; 6],
        weights: &PostureWeights,
    ) -> Option<Posture> {
        let mut order: Vec<(f64, &Posture)> = set
            .iter()
            .map(|p| (self.price_from(p, near, weights), p))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut copies = order.iter().filter_map(|(_, p)| {
            let joints = self.arm.nearest_copy(&p.joints, near)?;
            Some(Posture { joints, ..**p })
        });
        let first = copies.next()?;
        if self.line_is_free(near, &first.joints) {
            return Some(first);
        }
        Some(
            copies
                .find(|p| self.line_is_free(near, &p.joints))
                .unwrap_or(first),
        )
    }

    /// True if the straight joint motion from `a` to `b` keeps a self-clearance of [`SELF_MARGIN`], checked every
    /// 0.05 rad of the fastest joint.
    #[must_use]
    pub fn line_is_free(&self, a: &[f64; 6], b: &[f64; 6]) -> bool {
        let most = (0..6).map(|j| (b[j] - a[j]).abs()).fold(0.0, f64::max);
        if !most.is_finite() {
            return false;
        }
        let n = (most / 0.05).ceil().max(1.0) as usize;
        (0..=n).all(|i| {
            let t = i as f64 / n as f64;
            self.self_is_free(
                &[0, 1, 2, 3, 4, 5].map(|j| a[j] + t * (b[j] - a[j])),
                SELF_MARGIN,
            )
        })
    }

    fn measured(
        &self,
        view: &View,
        camera: &Frame,
        s: &CameraSolution,
        weights: &PostureWeights,
    ) -> Posture {
        let mut p = Posture {
            view: *view,
            joints: s.joints,
            camera: *camera,
            reach: 0.0,
            overhang: 0.0,
            clearance: s.clearance,
            manipulability: s.manipulability,
            hidden: 0.0,
            price: 0.0,
        };
        let state = BodyState {
            base: [0.0; 3],
            joints: p.joints,
        };
        let spheres = self.spheres_in_base(&p.joints);
        let (half_l, half_w) = (0.5 * self.base.length, 0.5 * self.base.width);
        for s in &spheres {
            let [x, y, _] = s.center;
            p.reach = p.reach.max(x.hypot(y) + s.radius);
            let out = (x.abs() + s.radius - half_l).max(y.abs() + s.radius - half_w);
            p.overhang = p.overhang.max(out);
        }
        p.hidden = self.hidden_share(&state, &p.camera, weights.tan_half);
        let elbow = self.arm_frames(&state)[2].p[2];
        let shoulder = self.mount.translation.z + self.arm.d1;
        p.price = weights.overhang * p.overhang
            + weights.height_price * (p.camera.p[2] - p.view.height).abs()
            + weights.offset * p.camera.p[1].abs()
            + weights.clearance_price * (weights.clearance - p.clearance).max(0.0)
            + weights.manipulability_price
                * (1.0 - p.manipulability / weights.manipulability).max(0.0)
            + weights.elbow_drop * (shoulder - elbow).max(0.0)
            + weights.hidden * p.hidden
            + weights.turn * p.joints.iter().map(|q| q.abs()).sum::<f64>();
        p
    }

    /// Share of a grid of 9 x 7 rays through the image that hit the robot.
    fn hidden_share(&self, state: &BodyState, camera: &Frame, tan_half: [f64; 2]) -> f64 {
        let solids = self.link_capsules(state);
        // In the optical frame; what lies behind the lens cannot be seen.
        let solids = solids.iter().map(|c| {
            (
                camera.apply_inverse(c.a),
                camera.apply_inverse(c.b),
                c.radius,
            )
        });
        let capsules: Vec<(V3, V3, f64)> = solids
            .filter(|(a, b, r)| a[2].max(b[2]) + r > 0.0)
            .collect();
        let base = self.base_box(state.base);
        let origin = base.frame.apply_inverse(camera.p);
        let (columns, rows) = (9, 7);
        let mut hit = 0;
        for i in 0..columns {
            for j in 0..rows {
                let u = tan_half[0] * (2.0 * (f64::from(i) + 0.5) / f64::from(columns) - 1.0);
                let v = tan_half[1] * (2.0 * (f64::from(j) + 0.5) / f64::from(rows) - 1.0);
                let ray = [u, v, 1.0];
                let blocked = capsules
                    .iter()
                    .any(|(a, b, r)| ray_hits_capsule(ray, *a, *b, *r))
                    || ray_hits_box(origin, camera.rotate(ray), base.half);
                hit += i32::from(blocked);
            }
        }
        f64::from(hit) / f64::from(columns * rows)
    }
}

/// Level postures whose neighbours are priced in full.
const HOMES: usize = 64;

fn no_posture(view: &View) -> Error {
    Error::NoPosture {
        height: view.height,
        pitch_degrees: view.pitch.to_degrees(),
    }
}

fn steps([first, last, step]: [f64; 3]) -> impl Iterator<Item = f64> {
    let n = if step > 0.0 {
        ((last - first) / step + 1e-9).floor().clamp(0.0, 1000.0) as usize
    } else {
        0
    };
    (0..=n).map(move |i| first + i as f64 * step)
}

/// True if a ray from the origin passes the segment within `radius`, checked at nine points of it.
fn ray_hits_capsule(ray: V3, a: V3, b: V3, radius: f64) -> bool {
    let square = dot(ray, ray);
    (0..=8).any(|i| {
        let point = add(a, scale(sub(b, a), f64::from(i) / 8.0));
        let along = dot(point, ray) / square;
        let off = sub(point, scale(ray, along));
        along > 0.0 && dot(off, off) < radius * radius
    })
}

fn ray_hits_box(origin: V3, ray: V3, half: V3) -> bool {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for i in 0..3 {
        if ray[i].abs() < 1e-12 {
            if origin[i].abs() > half[i] {
                return false;
            }
            continue;
        }
        let (a, b) = (
            (-half[i] - origin[i]) / ray[i],
            (half[i] - origin[i]) / ray[i],
        );
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter < leave
}
