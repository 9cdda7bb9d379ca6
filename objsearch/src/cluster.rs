//! Close-by view positions shared into clusters, so that few path searches serve many views.

/// Groups of points, each around one of its points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clusters {
    /// The point in the middle of each cluster.
    pub medoids: Vec<usize>,
    /// Cluster of each point.
    pub of: Vec<usize>,
}

/// Groups points of the plane (m) into at most `most` clusters, as FLAP does: starting from one medoid, assign all points
/// to the nearest and move each medoid to the point nearest to its cluster's mean until nothing changes; then make the
/// point farthest from its medoid a new one, and so on.
///
/// The first medoid is the point nearest to the mean of all. Points that are not finite go to the first cluster.
pub fn cluster(points: &[[f64; 2]], most: usize) -> Clusters {
    let n = points.len();
    let mut found = Clusters {
        medoids: Vec::new(),
        of: vec![0; n],
    };
    if n == 0 || most == 0 {
        return found;
    }
    let all: Vec<usize> = (0..n).collect();
    found.medoids.push(middle(points, &all));
    loop {
        settle(points, &mut found);
        if found.medoids.len() >= most {
            return found;
        }
        let away = |i: &usize| square(points[*i], points[found.medoids[found.of[*i]]]);
        // The lowest index among the farthest.
        let farthest = (0..n).rev().max_by(|a, b| away(a).total_cmp(&away(b)));
        match farthest.filter(|i| away(i) > 0.0 && away(i).is_finite()) {
            Some(i) => found.medoids.push(i),
            None => return found, // every point is a medoid, or stands on one
        }
    }
}

/// Assigns and moves medoids until nothing changes.
fn settle(points: &[[f64; 2]], clusters: &mut Clusters) {
    // Each round lowers the sum of squares but for ties; the limit guards against those.
    for _ in 0..100 {
        for (i, of) in clusters.of.iter_mut().enumerate() {
            let away = |c: &usize| square(points[i], points[clusters.medoids[*c]]);
            *of = (0..clusters.medoids.len())
                .min_by(|a, b| away(a).total_cmp(&away(b)))
                .unwrap_or(0);
        }
        let mut moved = false;
        for c in 0..clusters.medoids.len() {
            let members: Vec<usize> = (0..points.len()).filter(|&i| clusters.of[i] == c).collect();
            if members.is_empty() {
                continue;
            }
            let medoid = middle(points, &members);
            if medoid != clusters.medoids[c] {
                clusters.medoids[c] = medoid;
                moved = true;
            }
        }
        if !moved {
            return;
        }
    }
}

/// The member nearest to the mean of the members.
fn middle(points: &[[f64; 2]], members: &[usize]) -> usize {
    let mean =
        [0, 1].map(|a| members.iter().map(|&i| points[i][a]).sum::<f64>() / members.len() as f64);
    let away = |i: &&usize| square(points[**i], mean);
    members
        .iter()
        .min_by(|a, b| away(a).total_cmp(&away(b)))
        .copied()
        .unwrap_or(0)
}

fn square(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}
