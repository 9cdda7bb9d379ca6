//! Reads the benchmark problem and its instances (format heats-ipc-bench/1).

use ddp_rbf::nalgebra::SVector;
use ddp_rbf::{
    Barrier, BoxField, Chain, Constraint, Field, InputBox, Joint, LinkSphere, PairClearance,
    SphereClearance, StateBox, Tracking,
};
use serde_json::Value;
use std::error::Error;
use std::path::Path;

pub(crate) type X = SVector<f64, 9>;
pub(crate) type U = SVector<f64, 8>;
pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

/// Robot, weights and limits: what all instances share.
#[derive(Clone)]
pub(crate) struct Problem {
    pub(crate) chain: Chain,
    /// Spheres of the base that are held against the map, and those of the arm, which see the floor too.
    pub(crate) base: Vec<usize>,
    pub(crate) arm: Vec<usize>,
    pub(crate) pairs: Vec<(usize, usize)>,
    pub(crate) state_weight: X,
    pub(crate) input_weight: U,
    pub(crate) terminal_weight: X,
    pub(crate) input_limit: U,
    pub(crate) joint_limits: Vec<(usize, f64, f64)>,
    pub(crate) beta: f64,
    /// The paper's barrier.
    pub(crate) barrier: Barrier,
}

/// One room, start and reference.
pub(crate) struct Instance {
    pub(crate) name: String,
    pub(crate) boxes: Vec<[f64; 6]>,
    pub(crate) x0: X,
    /// At 0.025 s.
    pub(crate) states: Vec<X>,
    pub(crate) inputs: Vec<U>,
    optimum: Value,
}

/// Time between rows of the reference, s.
pub(crate) const ROW: f64 = 0.025;

fn numbers(v: &Value) -> Outcome<Vec<f64>> {
    let list = v.as_array().ok_or("expected a list of numbers")?;
    list.iter()
        .map(|v| v.as_f64().ok_or_else(|| "expected a number".into()))
        .collect()
}

fn vector<const N: usize>(v: &Value) -> Outcome<SVector<f64, N>> {
    let v = numbers(v)?;
    if v.len() != N {
        return Err(format!("expected {N} numbers, found {}", v.len()).into());
    }
    Ok(SVector::from_column_slice(&v))
}

fn rows<const N: usize>(v: &Value) -> Outcome<Vec<SVector<f64, N>>> {
    v.as_array()
        .ok_or("expected a list of rows")?
        .iter()
        .map(vector)
        .collect()
}

fn number(v: &Value, what: &str) -> Outcome<f64> {
    v.as_f64()
        .ok_or_else(|| format!("{what} is missing").into())
}

fn index(v: &Value) -> Outcome<usize> {
    Ok(v.as_u64().ok_or("expected an index")? as usize)
}

impl Problem {
    pub(crate) fn read(path: &Path) -> Outcome<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let all: Value = serde_json::from_str(&text)?;
        let robot = &all["robot"];
        let mount = numbers(&robot["mount"]["xyz"])?;
        let (sin, cos) = number(&robot["mount"]["yaw"], "mount.yaw")?.sin_cos();
        let joints = robot["dh"]
            .as_array()
            .ok_or("robot.dh is missing")?
            .iter()
            .map(|j| {
                Ok(Joint {
                    d: number(&j["d"], "d")?,
                    a: number(&j["a"], "a")?,
                    alpha: number(&j["alpha"], "alpha")?,
                })
            })
            .collect::<Outcome<Vec<_>>>()?;
        let (mut spheres, mut base, mut arm) = (Vec::new(), Vec::new(), Vec::new());
        for (i, s) in robot["spheres"]
            .as_array()
            .ok_or("no spheres")?
            .iter()
            .enumerate()
        {
            let o = numbers(&s["offset"])?;
            let frame = s["frame"].as_i64().ok_or("a sphere has no frame")?;
            // The arm's root does not move with a joint: into the base frame with it.
            let center = if frame == 0 {
                [
                    mount[0] + cos * o[0] - sin * o[1],
                    mount[1] + sin * o[0] + cos * o[1],
                    mount[2] + o[2],
                ]
            } else {
                [o[0], o[1], o[2]]
            };
            spheres.push(LinkSphere {
                link: frame.max(0) as usize,
                center,
                radius: number(&s["radius"], "radius")?,
            });
            if s["env"] == true {
                if frame < 0 { base.push(i) } else { arm.push(i) }
            }
        }
        let pairs = robot["pairs"]
            .as_array()
            .ok_or("no pairs")?
            .iter()
            .map(|p| Ok((index(&p[0])?, index(&p[1])?)))
            .collect::<Outcome<Vec<_>>>()?;
        let root = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let (low, high) = (
            numbers(&all["limits"]["q_min"])?,
            numbers(&all["limits"]["q_max"])?,
        );
        Ok(Self {
            chain: Chain::new(
                true,
                snapped(root),
                [mount[0], mount[1], mount[2]],
                joints,
                spheres,
            )?,
            base,
            arm,
            pairs,
            state_weight: vector(&all["cost"]["Q"])?,
            input_weight: vector(&all["cost"]["R"])?,
            terminal_weight: vector(&all["cost"]["Qf"])?,
            input_limit: vector(&all["limits"]["u_max"])?,
            joint_limits: (0..low.len()).map(|j| (3 + j, low[j], high[j])).collect(),
            beta: number(&all["field"]["beta"], "field.beta")?,
            barrier: Barrier {
                mu: number(&all["rbf"]["mu"], "rbf.mu")?,
                delta: number(&all["rbf"]["delta"], "rbf.delta")?,
                cutoff: None,
            },
        })
    }

    /// Tracking of `n` knots of `dt` s from row `from` of the reference on; past its end the last state is held.
    pub(crate) fn tracking(
        &self,
        instance: &Instance,
        n: usize,
        dt: f64,
        from: usize,
    ) -> Tracking<9, 8> {
        let stride = (dt / ROW).round() as usize;
        let last = instance.inputs.len();
        let states = (0..=n)
            .map(|k| instance.states[(from + stride * k).min(last)])
            .collect();
        let inputs = (0..n)
            .map(|k| {
                let rows = (0..stride).map(|r| {
                    let row = from + k * stride + r;
                    instance.inputs.get(row).copied().unwrap_or_else(U::zeros)
                });
                rows.sum::<U>() / stride as f64
            })
            .collect();
        Tracking::new(
            states,
            inputs,
            dt,
            self.state_weight,
            self.input_weight,
            self.terminal_weight,
        )
    }

    /// The two initial guesses of the problem: the reference with clipped inputs, and standing still.
    pub(crate) fn guesses(
        &self,
        instance: &Instance,
        cost: &Tracking<9, 8>,
    ) -> [(&'static str, Vec<X>, Vec<U>); 2] {
        let mut states = cost.states.clone();
        states[0] = instance.x0;
        let clip = self.input_limit * 0.9;
        let inputs = cost
            .inputs
            .iter()
            .map(|u| u.zip_map(&clip, |v, top| v.clamp(-top, top)))
            .collect();
        [
            ("reference", states, inputs),
            (
                "hold",
                vec![instance.x0; cost.states.len()],
                vec![U::zeros(); cost.inputs.len()],
            ),
        ]
    }

    /// Exact clearance of a state: of the environment (the floor for the arm included) and between the robot's own spheres.
    pub(crate) fn clearance(&self, boxes: &BoxField, x: &X) -> (f64, f64) {
        let centers = self.chain.centers(x.as_slice()).unwrap_or_default();
        let spheres = self.chain.spheres();
        let mut room = f64::INFINITY;
        for &i in self.base.iter().chain(&self.arm) {
            room = room.min(boxes.exact(centers[i]) - spheres[i].radius);
        }
        for &i in &self.arm {
            room = room.min(centers[i][2] - spheres[i].radius);
        }
        let mut own = f64::INFINITY;
        for &(i, j) in &self.pairs {
            let d = [0, 1, 2].map(|a| centers[i][a] - centers[j][a]);
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            own = own.min(length - spheres[i].radius - spheres[j].radius);
        }
        (room, own)
    }
}

/// Right angles are meant exactly.
fn snapped(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    m.map(|r| {
        r.map(|v| {
            if (v - v.round()).abs() < 1e-14 {
                v.round()
            } else {
                v
            }
        })
    })
}

impl Instance {
    pub(crate) fn read(path: &Path) -> Outcome<Self> {
        let text = std::fs::read_to_string(path)?;
        let all: Value = serde_json::from_str(&text)?;
        let boxes = rows::<6>(&all["boxes"])?;
        Ok(Self {
            name: all["name"].as_str().ok_or("no name")?.to_owned(),
            boxes: boxes
                .iter()
                .map(|b| std::array::from_fn(|i| b[i]))
                .collect(),
            x0: vector(&all["x0"])?,
            states: rows(&all["xref"])?,
            inputs: rows(&all["uref"])?,
            optimum: all["optimum"].clone(),
        })
    }

    /// All instances of a folder, by name.
    pub(crate) fn read_all(folder: &Path) -> Outcome<Vec<Self>> {
        let mut paths: Vec<_> = std::fs::read_dir(folder)
            .map_err(|e| format!("{}: {e}", folder.display()))?
            .filter_map(|entry| entry.ok().map(|e| e.path()))
            .filter(|p| {
                let name = p.file_name().and_then(|n| n.to_str()).unwrap_or("");
                name.ends_with(".json") && name.starts_with(|c: char| c.is_ascii_digit())
            })
            .collect();
        paths.sort();
        if paths.is_empty() {
            return Err(format!("{} holds no instance", folder.display()).into());
        }
        paths.iter().map(|p| Self::read(p)).collect()
    }

    /// Best objective of a variant ("rbf" or "hard") at `n` knots, if it is known.
    pub(crate) fn best(&self, variant: &str, n: usize) -> Option<f64> {
        self.optimum[format!("{variant}_N{n}")]["best_objective"].as_f64()
    }

    /// Objective of the rolled-out reference inputs.
    pub(crate) fn rolled_out(&self, n: usize) -> Option<f64> {
        self.optimum[format!("rbf_N{n}")]["rollout_of_reference_inputs"]["objective"].as_f64()
    }
}

/// Everything that makes up the constraints of one solve.
pub(crate) struct Terms<'a, A, B> {
    pub(crate) inputs: InputBox<8>,
    pub(crate) joints: StateBox,
    pub(crate) base: SphereClearance<'a, A>,
    pub(crate) arm: SphereClearance<'a, B>,
    pub(crate) own: PairClearance<'a>,
}

impl<'a, A: Field, B: Field> Terms<'a, A, B> {
    /// The five groups with one barrier; base and arm keep their `margins` from the fields, own spheres `own_margin`.
    pub(crate) fn new(
        problem: &'a Problem,
        barrier: Barrier,
        margins: [f64; 2],
        own_margin: f64,
        base_field: &'a A,
        arm_field: &'a B,
    ) -> Self {
        Self {
            inputs: InputBox::new(-problem.input_limit, problem.input_limit, barrier),
            joints: StateBox {
                limits: problem.joint_limits.clone(),
                barrier,
            },
            base: SphereClearance {
                chain: &problem.chain,
                field: base_field,
                spheres: &problem.base,
                margin: margins[0],
                on_base: false,
                barrier,
                name: "base clearance",
            },
            arm: SphereClearance {
                chain: &problem.chain,
                field: arm_field,
                spheres: &problem.arm,
                margin: margins[1],
                on_base: false,
                barrier,
                name: "arm clearance",
            },
            own: PairClearance {
                chain: &problem.chain,
                pairs: &problem.pairs,
                margin: own_margin,
                barrier,
                name: "self-clearance",
            },
        }
    }

    pub(crate) fn all(&self) -> [&dyn Constraint<9, 8>; 5] {
        [&self.inputs, &self.joints, &self.base, &self.arm, &self.own]
    }
}
