//! Does view planning work with another robot? A camera on a mast that lifts and turns: `cargo run --example swap_the_robot`.
#![allow(clippy::print_stdout)]

use viewsample::grid::Grid;
use viewsample::{
    Changes, Cluster, Error, Kind, Map, Params, Pose, Robot, Sampler, Straight, postures,
};

/// A round robot whose camera goes up and down and tilts; the base does the turning.
struct Mast<'a> {
    map: &'a Grid,
}

impl Mast<'_> {
    fn is_free_at(&self, point: [f64; 3]) -> bool {
        self.map.is_free(self.map.cell_at(point))
    }
}

impl Robot for Mast<'_> {
    /// Height, m, and tilt, rad.
    type State = [f64; 2];

    fn reach(&self, base_from_camera: &Pose) -> Option<[f64; 2]> {
        let [x, y, z] = base_from_camera.translation;
        // The optical axis is the third column; the mast stands in the middle and looks ahead.
        let axis = [0, 1, 2].map(|k| base_from_camera.rotation[k][2]);
        let ahead = x.abs() < 0.15 && y.abs() < 1e-6 && axis[1].abs() < 1e-6 && axis[0] > 0.0;
        (ahead && (0.5..=1.6).contains(&z)).then(|| [z, axis[2].asin()])
    }
    fn is_free(&self, base: [f64; 3], state: &[f64; 2]) -> bool {
        self.base_is_free(base) && self.is_free_at([base[0], base[1], state[0]])
    }
    fn base_is_free(&self, base: [f64; 3]) -> bool {
        (0..8).all(|k| {
            let (s, c) = (f64::from(k) * std::f64::consts::TAU / 8.0).sin_cos();
            self.is_free_at([base[0] + 0.3 * c, base[1] + 0.3 * s, 0.1])
        })
    }
}

fn main() -> Result<(), Error> {
    let row = format!("#{}????\n", ".".repeat(17));
    let plan = format!("{0}\n{1}{0}", "#".repeat(22), row.repeat(8));
    let map = Grid::parse(&plan, 8, 0.3);
    let robot = Mast { map: &map };
    let params = Params {
        lidar: None,
        ahead: vec![0.1],
        ..Params::default()
    };
    let mut sampler = Sampler::new(&params, postures(&robot, &params)?)?;
    let cells = map.exploration();
    let end = Cluster {
        id: 1,
        kind: Kind::Exploration,
        cells: &cells,
        centroid: [5.4, 1.5, 1.2],
    };
    let changes = Changes {
        added: &[end],
        boxes: &[map.bounds()],
        ..Changes::default()
    };
    sampler.update(&map, &changes)?;
    let costs = Straight {
        base_speed: 0.8,
        joint_speed: [0.3, 0.8],
    };
    let found = sampler.candidates(&robot, &costs, [1.0, 1.5, 0.0], &[1.0, 0.0])?;
    for view in &found.views {
        println!(
            "stand at {:.2?}, camera {:.2} m up, tilted {:.0} degrees: {} voxels in {:.1} s",
            view.base,
            view.state[0],
            view.state[1].to_degrees(),
            view.gain.exploration,
            view.seconds
        );
    }
    Ok(())
}
