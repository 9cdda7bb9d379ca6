//! The laws of [`Map`], [`Robot`] and [`CostModel`] as functions, for the tests of implementors.
//!
//! Each returns what is wrong in words, or nothing.

use std::ops::ControlFlow;

use crate::map::{Cell, Map};
use crate::sight;
use crate::{CostModel, Posture, Robot};

/// Checks the laws of [`Map`] on the cells given, and sight along the rays given (from a point
/// in m to a cell).
///
/// Where a map brings its own walk, the two may differ where a ray meets an edge of a cell
/// to the last bit: give rays in general position.
///
/// # Errors
/// What is wrong.
pub fn check_map<M: Map + ?Sized>(
    map: &M,
    cells: &[Cell],
    rays: &[([f64; 3], Cell)],
) -> Result<(), String> {
    let h = map.cell_size();
    if !(h > 0.0 && h.is_finite()) {
        return Err(format!("cell size {h} m"));
    }
    for &c in cells {
        if map.is_free(c) && map.is_occupied(c) {
            return Err(format!("{c:?} is both free and occupied"));
        }
        let p = map.center(c);
        if map.cell_at(p) != c {
            return Err(format!("the centre of {c:?} lies in {:?}", map.cell_at(p)));
        }
        for a in 0..3 {
            let mut next = c;
            next[a] += 1;
            let step = map.center(next)[a] - p[a];
            if (step - h).abs() > 1e-9 {
                return Err(format!("{c:?} and {next:?} are {step} m apart, not {h} m"));
            }
        }
        let (free, occupied) = map.column(c, 64);
        for n in 0..64 {
            let d = [c[0], c[1], c[2].saturating_add(n)];
            if (free >> n & 1 != 0) != map.is_free(d)
                || (occupied >> n & 1 != 0) != map.is_occupied(d)
            {
                return Err(format!("column({c:?}) disagrees with {d:?}"));
            }
        }
        if map.column(c, 3).0 >> 3 != 0 || map.column(c, 3).1 >> 3 != 0 {
            return Err(format!("column({c:?}, 3) has more than 3 bits"));
        }
    }
    for &(from, to) in rays {
        for allowance in [0, 2, 50] {
            let (theirs, ours) = (
                map.line_of_sight(from, to, allowance),
                sight::line_of_sight(map, from, to, allowance),
            );
            if theirs != ours {
                return Err(format!(
                    "line_of_sight({from:?}, {to:?}, {allowance}) = {theirs}, by definition {ours}"
                ));
            }
        }
        let (mut first, mut last, mut broken) = (None, None, None);
        map.walk(from, map.center(to), &mut |c| {
            if let Some(before) =
                last.filter(|l: &Cell| (0..3).map(|a| l[a].abs_diff(c[a])).sum::<u32>() != 1)
            {
                broken = Some((before, c));
                return ControlFlow::Break(());
            }
            first.get_or_insert(c);
            last = Some(c);
            ControlFlow::Continue(())
        });
        if let Some((a, b)) = broken {
            return Err(format!("the walk steps from {a:?} to {b:?}"));
        }
        if first != Some(map.cell_at(from)) || last != Some(to) {
            return Err(format!(
                "the walk from {from:?} to {to:?} runs from {first:?} to {last:?}"
            ));
        }
    }
    Ok(())
}

/// Checks that a free body has a free base, for the base poses given.
///
/// # Errors
/// What is wrong.
pub fn check_robot<R: Robot>(
    robot: &R,
    postures: &[Posture<R::State>],
    bases: &[[f64; 3]],
) -> Result<(), String> {
    for base in bases {
        for posture in postures {
            if robot.is_free(*base, &posture.state) && !robot.base_is_free(*base) {
                return Err(format!(
                    "view {} at {base:?}: the body is free and the base is not",
                    posture.view
                ));
            }
        }
    }
    Ok(())
}

/// Checks that no way takes negative time and that staying takes none, among the places given.
///
/// # Errors
/// What is wrong.
pub fn check_costs<S, C: CostModel<S> + ?Sized>(
    costs: &C,
    places: &[([f64; 3], S)],
) -> Result<(), String> {
    for (n, (base, state)) in places.iter().enumerate() {
        let stay = costs.seconds((base, state), (base, state));
        if stay.abs() > 1e-9 {
            return Err(format!("staying at {base:?} takes {stay} s"));
        }
        for (other, there) in &places[n + 1..] {
            let t = costs.seconds((base, state), (other, there));
            if t < 0.0 {
                return Err(format!("{base:?} to {other:?} takes {t} s"));
            }
        }
    }
    Ok(())
}
