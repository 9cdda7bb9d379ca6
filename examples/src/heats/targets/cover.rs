//! Few views instead of many: those of the robot's region, of its place and aimed ones, thinned to what soonest covers all they see.

use super::{Costs, LAST_INCIDENCE, LAST_TARGET, Targets, rate_of, seen};
use crate::heats::body::{Joints, Whole};
use crate::heats::glance::Look;
use crate::heats::pace::Pace;
use std::collections::{BTreeMap, BTreeSet};
use viewsample::{Aim, CostModel, Viewpoint};

/// Time that a view takes beyond the way to it, s.
const STAY: f64 = 0.3;
/// Views of a cover at most: farther ahead all will have changed.
const MOST: usize = 30;
/// Largest incidence of the last tries, rad.
const MOST_INCIDENCE: f64 = 1.3;
/// Least distance of the points at which a straight line is held against the map, m.
const LINE_STEP: f64 = 0.2;
/// How much longer than the blocked straight line a way is taken to be: a factor and metres.
const DETOUR: (f64, f64) = (1.5, 0.5);

impl Targets {
    /// Least information a second in this round: first what pays well for its time, everywhere; the rest in later rounds.
    pub(super) fn round<'v>(&self, views: impl IntoIterator<Item = &'v Viewpoint<Joints>>) -> f64 {
        let best = views
            .into_iter()
            .map(|v| rate_of(v, self.rate_span))
            .fold(0.0, f64::max);
        let rate = self.rates.iter().copied().find(|&rate| best >= rate);
        rate.unwrap_or(0.0)
    }

    /// How this decision aims views: 0 at first, 1 in the last tries; each decision draws anew.
    fn aim(&self, stage: usize) -> Aim {
        Aim {
            seed: self.seed ^ self.decisions.wrapping_mul(0x2545_f491_4f6c_dd1d),
            ..self.aims[stage].clone()
        }
    }

    /// Of the views in the robot's region, those from where it stands, those of the last cover and newly aimed ones, the ones that
    /// soonest cover what all of them see; the views of other regions stay as they are.
    pub(super) fn fewest(
        &mut self,
        whole: &Whole<'_>,
        costs: &Costs<'_>,
        robot: &([f64; 3], Joints),
        (here, before): ([f64; 2], &[Look]),
        views: Vec<Viewpoint<Joints>>,
        effort: &mut viewsample::Effort,
    ) -> Result<Vec<Viewpoint<Joints>>, String> {
        let Some(regions) = &whole.mapper.regions else {
            return Ok(views);
        };
        let region = regions.nearest_label(here);
        let (mut near, mut kept): (Vec<_>, Vec<_>) = views
            .into_iter()
            .partition(|v| regions.nearest_label([v.base[0], v.base[1]]) == region);
        let (turns, spent) = self
            .sampler
            .views_from(&[here], whole, costs, robot.0, &robot.1)
            .map_err(|e| e.to_string())?;
        *effort += spent;
        near.extend(turns);
        if self.aimed > 0 {
            let again: Vec<_> = self
                .kept
                .iter()
                .filter(|v| regions.nearest_label([v.base[0], v.base[1]]) == region)
                .filter(|v| viewsample::Robot::is_free(whole, v.base, &v.state))
                .map(|v| Viewpoint {
                    gain: self.sampler.gain_at(v.base, &v.camera).unwrap_or_default(),
                    seconds: costs.seconds((&robot.0, &robot.1), (&v.base, &v.state)),
                    ..v.clone()
                })
                .filter(|v| v.seconds.is_finite() && v.gain.info >= self.threshold())
                .collect();
            let mut places = vec![here];
            places.extend(again.iter().map(|v| [v.base[0], v.base[1]]));
            near.extend(again);
            let map = &whole.mapper.map;
            let ids: Vec<u64> = self
                .frontiers
                .clusters()
                .filter(|c| self.held.contains(&c.id))
                .filter(|c| {
                    let p = [0, 1].map(|a| map.low()[a] + c.centroid[a] * map.cell_size());
                    regions.nearest_label(p) == region
                })
                .map(|c| c.id)
                .collect();
            let aim = self.aim(0);
            let (aimed, spent) = self
                .sampler
                .aimed(
                    &aim,
                    &ids,
                    &places,
                    whole,
                    costs,
                    (&robot.0, &robot.1),
                    None,
                )
                .map_err(|e| e.to_string())?;
            *effort += spent;
            near.extend(aimed);
        }
        let seconds = between(whole, self.pace, &near);
        let (chosen, spent) = self
            .sampler
            .cover_by_rate(before, &near, MOST, self.threshold(), STAY, seconds)
            .map_err(|e| e.to_string())?;
        *effort += spent;
        let most = chosen.iter().map(|c| c.1.info).fold(0.0, f64::max);
        self.kept.clear();
        for (index, gain) in chosen {
            self.kept.push(near[index].clone());
            if gain.info < (self.cover_share * most).min(self.cover_most) {
                continue;
            }
            let mut view = near[index].clone();
            view.gain = gain;
            kept.push(view);
        }
        // What a view adds to others may pay less than the view alone.
        let rate = self.round(&kept);
        kept.retain(|v| rate_of(v, self.rate_span) >= rate);
        Ok(kept)
    }

    /// Largest incidence of the last tries, rad; none for the published rule.
    pub(super) fn last_incidence(&self) -> Option<f64> {
        let usual = self.sampler.params().max_incidence;
        usual.map(|most| (most + LAST_INCIDENCE).min(MOST_INCIDENCE))
    }

    /// The last tries for the clusters named, each once and with relaxed limits: views of the nearest region in which there are any.
    pub(super) fn last_tries(
        &mut self,
        ids: &[u64],
        whole: &Whole<'_>,
        costs: &Costs<'_>,
        robot: &([f64; 3], Joints),
        (here, before): ([f64; 2], &[Look]),
    ) -> Result<(Vec<Viewpoint<Joints>>, viewsample::Effort), String> {
        let mut effort = viewsample::Effort::default();
        let Some(regions) = &whole.mapper.regions else {
            return Ok((Vec::new(), effort));
        };
        let map = &whole.mapper.map;
        let mut left: BTreeMap<Option<u32>, Vec<u64>> = BTreeMap::new();
        for &id in ids {
            if let Some(c) = self.frontiers.get(id)
                && c.cells.iter().any(|c| !self.tried.contains(c))
            {
                let p = [0, 1].map(|a| map.low()[a] + c.centroid[a] * map.cell_size());
                left.entry(regions.nearest_label(p)).or_default().push(id);
            }
        }
        let own = regions.nearest_label(here);
        let off = |label: &Option<u32>| {
            let center = label.and_then(|l| regions.center(l)).unwrap_or(here);
            let apart = (center[0] - here[0]).hypot(center[1] - here[1]);
            if *label == own { -1.0 } else { apart }
        };
        let mut order: Vec<_> = left.into_iter().collect();
        order.sort_by(|a, b| off(&a.0).total_cmp(&off(&b.0)));
        let aim = self.aim(1);
        let (pace, incidence) = (self.pace, self.last_incidence());
        for (_, ids) in order {
            let (reach, tried) = (&mut self.reach, &self.tried);
            let found = self
                .sampler
                .with_limits(Some(LAST_TARGET), incidence, |sampler| {
                    let at = (&robot.0, &robot.1);
                    let (mut views, mut effort) =
                        sampler.aimed(&aim, &ids, &[here], whole, costs, at, Some(reach))?;
                    // What was tried before does not count.
                    views.retain(|v| {
                        let cells = seen(sampler, v.base, &v.camera);
                        let new = cells.iter().filter(|c| !tried.contains(*c)).count();
                        v.gain.info * new as f64 >= aim.threshold * cells.len() as f64
                    });
                    let with: BTreeSet<_> = views.iter().filter_map(|v| v.cluster).collect();
                    let (chosen, spent) = sampler.cover_by_rate(
                        before,
                        &views,
                        MOST,
                        aim.threshold,
                        STAY,
                        between(whole, pace, &views),
                    )?;
                    effort += spent;
                    let views: Vec<_> = chosen.iter().map(|c| views[c.0].clone()).collect();
                    Ok::<_, viewsample::Error>((views, with, effort))
                });
            let (views, with, spent) = found.and_then(|f| f).map_err(|e| e.to_string())?;
            effort += spent;
            if before.is_empty() {
                for id in ids.iter().filter(|id| !with.contains(id)) {
                    if let Some(c) = self.frontiers.get(*id) {
                        self.tried.extend(c.cells.iter().copied());
                    }
                }
            }
            if !views.is_empty() {
                self.kept.clone_from(&views);
                return Ok((views, effort));
            }
        }
        Ok((Vec::new(), effort))
    }

    /// As [`last_tries`](Self::last_tries), from the libraries alone.
    pub(super) fn retry(
        &mut self,
        ids: &[u64],
        whole: &Whole<'_>,
        costs: &Costs<'_>,
        robot: &([f64; 3], Joints),
    ) -> Result<(Vec<Viewpoint<Joints>>, viewsample::Effort), String> {
        let ids: Vec<u64> = ids
            .iter()
            .copied()
            .filter(|&id| {
                self.frontiers
                    .get(id)
                    .is_some_and(|c| c.cells.iter().any(|c| !self.tried.contains(c)))
            })
            .collect();
        let found = self
            .sampler
            .retry(&ids, whole, costs, robot.0, &robot.1)
            .map_err(|e| e.to_string())?;
        for id in ids {
            if !found.views.iter().any(|v| v.cluster == Some(id))
                && let Some(c) = self.frontiers.get(id)
            {
                self.tried.extend(c.cells.iter().copied());
            }
        }
        Ok((found.views, found.effort))
    }
}

/// Seconds from one of the views, or from where the robot is (`None`), to another.
fn between<'a>(
    whole: &'a Whole<'a>,
    pace: Pace,
    views: &'a [Viewpoint<Joints>],
) -> impl FnMut(Option<usize>, usize) -> f64 + 'a {
    move |from, to| {
        let Some(from) = from else {
            return views[to].seconds;
        };
        let (a, b) = (&views[from], &views[to]);
        let way = meters(whole, &a.base, &b.base);
        pace.seconds(way, (&a.base, &a.state), (&b.base, &b.state))
    }
}

/// Length of the way between two places of a region, m. Regions are nearly convex: the straight line is nearly the way, where it is free.
fn meters(whole: &Whole<'_>, a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let ground = &whole.mapper.ground;
    let clear = 0.5 * whole.robot.base.width;
    let length = (a[0] - b[0]).hypot(a[1] - b[1]);
    // As far at once as the room around a point says.
    let mut at = 0.0;
    let mut free = true;
    while free && at < length {
        let t = at / length;
        let room = ground.clearance([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        free = at == 0.0 || room >= clear;
        at += (room - clear).max(LINE_STEP);
    }
    if free {
        length
    } else {
        DETOUR.0 * length + DETOUR.1
    }
}
