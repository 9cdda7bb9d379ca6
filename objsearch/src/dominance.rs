//! Views that a better one makes needless (xi, FLAP eq. 7).

use crate::branch::Child;
use crate::cover::Cover;
use crate::task::Task;

/// Which views the branch and bound drops for a better one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dominance {
    /// None (xi = 0).
    #[default]
    Off,
    /// A view with smaller probability and larger time than one already followed from the same node (xi = 1 as FLAP's
    /// program has it). May lose the optimum.
    Siblings,
    /// A view with smaller probability and larger time than any other (xi = 1 as eq. 7 reads). May lose the optimum.
    All,
    /// A view that shows no more than another, which is reached no later and from which every third view is reached
    /// no later. Never loses the optimum where a detour is never shorter than the direct way.
    Safe,
}

/// What dominance needs to know beforehand.
#[derive(Clone, Debug)]
pub(crate) struct Pairs {
    kind: Dominance,
    /// For [`Dominance::Safe`]: the views from which nothing takes longer than from this one.
    nearer: Vec<Vec<u32>>,
}

impl Pairs {
    pub(crate) fn new(task: &Task, kind: Dominance) -> Self {
        let n = task.len();
        let no_later = |i: usize, k: usize| {
            (0..n)
                .filter(|&j| j != i && j != k)
                .all(|j| task.seconds(Some(i), j) <= task.seconds(Some(k), j))
        };
        let nearer = if kind == Dominance::Safe {
            (0..n)
                .map(|k| {
                    (0..n)
                        .filter(|&i| i != k && no_later(i, k))
                        .map(|i| i as u32)
                        .collect()
                })
                .collect()
        } else {
            Vec::new()
        };
        Self { kind, nearer }
    }

    /// Whether child `index` is dominated; the first `expanded` children were followed before it.
    pub(crate) fn dominated(
        &self,
        task: &Task,
        cover: &Cover,
        children: &[Child],
        index: usize,
        expanded: usize,
    ) -> bool {
        let this = children[index];
        let better =
            |other: &Child| other.probability > this.probability && other.seconds < this.seconds;
        match self.kind {
            Dominance::Off => false,
            Dominance::Siblings => children[..expanded].iter().any(better),
            Dominance::All => children.iter().any(better),
            Dominance::Safe => self.nearer[this.view].iter().any(|&i| {
                let i = i as usize;
                let Some(other) = children.iter().find(|c| c.view == i) else {
                    return false;
                };
                if other.seconds > this.seconds || !shows_no_more(task, cover, this.view, i) {
                    return false;
                }
                // Two that dominate each other: the lower index stays.
                let mutual = this.seconds <= other.seconds
                    && self.nearer[i].contains(&(this.view as u32))
                    && shows_no_more(task, cover, i, this.view);
                !mutual || i < this.view
            }),
        }
    }
}

/// Whether every uncovered class of view `a` is also shown by view `b`.
fn shows_no_more(task: &Task, cover: &Cover, a: usize, b: usize) -> bool {
    let other = task.classes(b);
    task.classes(a)
        .iter()
        .all(|c| cover.remaining(task, *c) == 0.0 || other.binary_search(c).is_ok())
}
