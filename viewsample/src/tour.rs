//! Views by what they add for their time: a tour that grows by cheapest insertion.

use crate::cover::{Covered, SharedLidar, Sight};
use crate::sampler::Sampler;
use crate::{Effort, Error, Gain, Pose, Viewpoint};

/// An open tour over chosen views that starts where the robot is, and the times that inserting another view needs.
struct Tour {
    /// Numbers of chosen views in the order of the tour.
    order: Vec<usize>,
    /// For each view, the time from the robot, s.
    from_robot: Vec<f64>,
    /// For each view, the time from each chosen one, and to it, s.
    from: Vec<Vec<f64>>,
    to: Vec<Vec<f64>>,
    /// The views chosen.
    chosen: Vec<usize>,
}

impl Tour {
    fn new(from_robot: Vec<f64>) -> Self {
        let views = from_robot.len();
        Self {
            order: Vec::new(),
            from_robot,
            from: vec![Vec::new(); views],
            to: vec![Vec::new(); views],
            chosen: Vec::new(),
        }
    }

    /// Time to a view from a chosen one, or from the robot, s.
    fn leg(&self, from: Option<usize>, view: usize) -> f64 {
        from.map_or(self.from_robot[view], |number| self.from[view][number])
    }

    /// By how much a view lengthens the tour at least (s), and where it comes then.
    fn insertion(&self, view: usize) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for place in 0..=self.order.len() {
            let before = place.checked_sub(1).map(|k| self.order[k]);
            let mut longer = self.leg(before, view);
            if let Some(&next) = self.order.get(place) {
                longer += self.to[view][next] - self.leg(before, self.chosen[next]);
            }
            if longer < best.0 {
                best = (longer, place);
            }
        }
        (best.0.max(0.0), best.1)
    }

    fn insert(&mut self, view: usize, mut seconds: impl FnMut(Option<usize>, usize) -> f64) {
        let (_, place) = self.insertion(view);
        self.order.insert(place, self.chosen.len());
        self.chosen.push(view);
        for other in 0..self.from.len() {
            self.from[other].push(seconds(Some(view), other));
            self.to[other].push(seconds(Some(other), view));
        }
    }
}

impl<S: Clone> Sampler<S> {
    /// Greedy cover by rate: again and again the view that adds most for each second by which it lengthens an open tour from
    /// the robot over those chosen, as long as it adds at least `least`, at most `most` of them. Returns indices and what each adds, in the order of
    /// choice. What the base and camera poses `before` show adds nothing.
    ///
    /// `seconds` is asked for the time from one view, or from the robot (`None`), to another; a view that is never reached has
    /// infinity. Each view costs `stay` s on top, so that none is free.
    ///
    /// Where [`cover`](Self::cover) takes the fewest views, however far apart, this takes those that are done soonest (the
    /// cost-benefit rule for submodular cover: Wolsey 1982; Leskovec et al. 2007).
    ///
    /// # Errors
    /// If a pose is not finite, or `stay` is not positive.
    pub fn cover_by_rate(
        &self,
        before: &[([f64; 3], Pose)],
        views: &[Viewpoint<S>],
        most: usize,
        least: f64,
        stay: f64,
        mut seconds: impl FnMut(Option<usize>, usize) -> f64,
    ) -> Result<(Vec<(usize, Gain)>, Effort), Error> {
        if !(stay > 0.0 && stay.is_finite()) {
            return Err(Error::Param {
                field: "stay",
                value: stay,
                range: "positive and finite",
            });
        }
        let mut effort = Effort::default();
        let mut lidar = SharedLidar::default();
        let mut covered = Covered::default();
        for (base, camera) in before {
            effort.camera_views += 1;
            covered.add(&self.sight_sharing(&mut lidar, *base, camera)?);
        }
        let from_robot: Vec<f64> = (0..views.len()).map(|i| seconds(None, i)).collect();
        let mut open: Vec<usize> = (0..views.len())
            .filter(|&i| from_robot[i].is_finite())
            .collect();
        let mut longer = from_robot.clone();
        let mut tour = Tour::new(from_robot);
        let mut sights: Vec<Option<Sight>> = vec![None; views.len()];
        // What a view adds only shrinks: the last figure is an upper bound.
        let mut adds: Vec<Gain> = views.iter().map(|v| v.gain).collect();
        let mut chosen = Vec::new();
        let mut exact = vec![false; views.len()];
        while chosen.len() < most
            && let Some(&best) = open.iter().max_by(|&&a, &&b| {
                let rate = |i: usize| adds[i].info / (longer[i] + stay);
                rate(a).total_cmp(&rate(b)).then(b.cmp(&a))
            })
        {
            if !exact[best] {
                let sight = match &mut sights[best] {
                    Some(sight) => sight,
                    slot => {
                        effort.camera_views += 1;
                        let view = &views[best];
                        slot.insert(self.sight_sharing(&mut lidar, view.base, &view.camera)?)
                    }
                };
                adds[best] = covered.added(self, sight);
                exact[best] = true;
                if adds[best].info < least || adds[best].info <= 0.0 {
                    open.retain(|&i| i != best);
                }
                continue;
            }
            if let Some(sight) = &sights[best] {
                covered.add(sight);
            }
            chosen.push((best, adds[best]));
            open.retain(|&i| i != best);
            exact.fill(false);
            tour.insert(best, &mut seconds);
            for &i in &open {
                longer[i] = tour.insertion(i).0;
            }
        }
        Ok((chosen, effort))
    }
}
