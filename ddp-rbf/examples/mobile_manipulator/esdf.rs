//! Occupancy of boxes in voxels, and the distance field a robot would have of it.

use crate::problem::Outcome;
use ddp_rbf::GridField;

/// Beyond this distances are cut, m.
const FAR: f32 = 3.0;

/// Distance to the surface of the occupied voxels of `cell` m, negative inside: what mapping would make of the boxes.
pub(crate) fn of_boxes(boxes: &[[f64; 6]], cell: f64) -> Outcome<GridField> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for b in boxes {
        for a in 0..3 {
            low[a] = low[a].min(b[a] - b[3 + a]);
            high[a] = high[a].max(b[a] + b[3 + a]);
        }
    }
    let size = [0, 1, 2].map(|a| (((high[a] - low[a]) / cell).ceil() as usize).max(1) + 2);
    // One voxel of air around; centres lie half a voxel inside.
    let first = [0, 1, 2].map(|a| low[a] - 0.5 * cell);
    let mut occupied = vec![false; size.iter().product()];
    for b in boxes {
        // Voxels whose cube overlaps the box, with no thickness for touching.
        let range = |a: usize| {
            let t = |v: f64| (v - first[a]) / cell + 0.5;
            let from = (t(b[a] - b[3 + a]) + 1e-6).floor().max(0.0) as usize;
            let to = (t(b[a] + b[3 + a]) - 1e-6).floor() as usize;
            from..(to + 1).min(size[a])
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    occupied[x + size[0] * (y + size[1] * z)] = true;
                }
            }
        }
    }
    let outside = squared_distances(&occupied, size, true);
    let inside = squared_distances(&occupied, size, false);
    let h = cell as f32;
    let distances = outside
        .iter()
        .zip(&inside)
        .map(|(o, i)| {
            if *o > 0.0 {
                (o.sqrt() * h).min(FAR)
            } else {
                (-i.sqrt() * h).max(-FAR)
            }
        })
        .collect();
    Ok(GridField::new(first, cell, size, distances)?)
}

/// Squared distance, in voxels, from the centre of each voxel to the nearest cube whose occupancy is `to`: exact, one axis
/// after the other by the lower envelope of parabolas. Along an axis the nearest point of a cube lies level with its centre
/// or on a face, so faces between voxels stand in the line as sites of their own.
fn squared_distances(occupied: &[bool], size: [usize; 3], to: bool) -> Vec<f32> {
    let none = 1e12f64;
    let mut d: Vec<f64> = occupied
        .iter()
        .map(|&o| if o == to { 0.0 } else { none })
        .collect();
    let stride = [1, size[0], size[0] * size[1]];
    let longest = size.iter().copied().max().unwrap_or(0);
    let mut line = vec![0.0; 2 * longest];
    let mut places = vec![0usize; 2 * longest];
    let mut edges = vec![0.0; 2 * longest + 1];
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        for i in 0..size[b] {
            for j in 0..size[c] {
                let start = i * stride[b] + j * stride[c];
                let n = size[a];
                // Even sites are centres, odd ones the faces after them.
                for q in 0..n {
                    line[2 * q] = d[start + q * stride[a]];
                }
                for q in 0..n - 1 {
                    line[2 * q + 1] = line[2 * q].min(line[2 * q + 2]);
                }
                let mut top = 0;
                (places[0], edges[0], edges[1]) = (0, f64::NEG_INFINITY, f64::INFINITY);
                for q in 1..2 * n - 1 {
                    loop {
                        let p = places[top];
                        let (qf, pf) = (0.5 * q as f64, 0.5 * p as f64);
                        let cross = ((line[q] + qf * qf) - (line[p] + pf * pf)) / (2.0 * (qf - pf));
                        if cross <= edges[top] && top > 0 {
                            top -= 1;
                            continue;
                        }
                        if cross > edges[top] {
                            top += 1;
                            places[top] = q;
                            edges[top] = cross;
                        } else {
                            // The first parabola is beaten everywhere.
                            places[0] = q;
                        }
                        edges[top + 1] = f64::INFINITY;
                        break;
                    }
                }
                let mut k = 0;
                for q in 0..n {
                    while edges[k + 1] < q as f64 {
                        k += 1;
                    }
                    let way = q as f64 - 0.5 * places[k] as f64;
                    d[start + q * stride[a]] = line[places[k]] + way * way;
                }
            }
        }
    }
    d.into_iter().map(|v| v as f32).collect()
}
