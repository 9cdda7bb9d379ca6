//! Lone returns: what a driver drops of a range image that holds outliers.

/// Bend of the range image over three neighbouring rays that a smooth surface may have, m, and as a share of the range.
const BEND: (f64, f64) = (0.02, 0.005);

/// The rays to keep of a range image, rows of `width`: those that lie on a line with both neighbours along a row or along a
/// column, or that have two of the four neighbours at their own range. A lone return in the air has neither; edges and corners of
/// solids have. `sigma` is the range noise as a share of the range. Rows are closed to rings if `around`. Ranges that are not
/// numbers are not kept.
pub(crate) fn keep(range: &[f32], width: usize, around: bool, sigma: f64, out: &mut Vec<bool>) {
    out.clear();
    let height = range.len() / width.max(1);
    let at = |x: usize, y: usize| f64::from(range[y * width + x]);
    for y in 0..height {
        for x in 0..width {
            let here = at(x, y);
            let left = if x > 0 {
                at(x - 1, y)
            } else if around {
                at(width - 1, y)
            } else {
                f64::NAN
            };
            let right = if x + 1 < width {
                at(x + 1, y)
            } else if around {
                at(0, y)
            } else {
                f64::NAN
            };
            let below = if y > 0 { at(x, y - 1) } else { f64::NAN };
            let above = if y + 1 < height {
                at(x, y + 1)
            } else {
                f64::NAN
            };
            let step = BEND.0 + here * (BEND.1 + 3.0 * sigma);
            // The second difference of three independent ranges has sqrt(6) times the deviation of one.
            let line = |a: f64, b: f64| (a + b - 2.0 * here).abs() <= 2.0 * step;
            let like = [left, right, below, above]
                .iter()
                .filter(|n| (*n - here).abs() <= step)
                .count();
            out.push(here.is_finite() && (like >= 2 || line(left, right) || line(below, above)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(range: &[f32], width: usize, around: bool) -> Vec<bool> {
        let mut out = Vec::new();
        keep(range, width, around, 0.0, &mut out);
        out
    }

    #[test]
    fn a_lone_return_goes_and_its_neighbours_stay() {
        // A floor seen at a flat angle: rows differ by half a metre, columns not at all.
        let mut range: Vec<f32> = (0..7 * 9).map(|i| 2.0 + 0.5 * (i / 9) as f32).collect();
        assert!(kept(&range, 9, true).iter().all(|k| *k));
        range[3 * 9 + 4] = 1.1;
        let keep = kept(&range, 9, true);
        assert!(!keep[3 * 9 + 4]);
        assert_eq!(keep.iter().filter(|k| !**k).count(), 1, "{keep:?}");
    }

    #[test]
    fn the_edge_of_a_post_two_rays_wide_stays() {
        let mut range = vec![5.0_f32; 6 * 8];
        for y in 0..6 {
            range[y * 8 + 3] = 2.0;
            range[y * 8 + 4] = 2.0;
        }
        assert!(kept(&range, 8, false).iter().all(|k| *k));
    }

    #[test]
    fn rings_close_and_lost_rays_do_not_count() {
        let mut range = vec![3.0_f32; 4];
        range[2] = f32::NAN;
        assert_eq!(kept(&range, 4, true), [true, false, false, false]);
        assert_eq!(kept(&[3.0; 4], 4, true), [true; 4]);
        assert_eq!(kept(&[3.0; 4], 4, false), [false, true, true, false]);
    }
}
