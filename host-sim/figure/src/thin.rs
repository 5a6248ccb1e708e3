//! Reduces the points of a curve (Ramer, Douglas and Peucker).

type Point = (f64, f64);

/// Largest distance of a removed point from the drawn curve, in units of the sheet: a tenth of a
/// thin line's width.
const TOLERANCE: f64 = 0.1;

/// Returns the points of a curve without those that make no visible difference. `unit` is the size
/// of a unit of the sheet on either axis.
pub(super) fn thin(points: &[Point], unit: [f64; 2]) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let on_sheet = |i: usize| (points[i].0 / unit[0], points[i].1 / unit[1]);
    let mut kept = vec![false; points.len()];
    let mut stretches = vec![(0, points.len() - 1)];
    while let Some((from, to)) = stretches.pop() {
        (kept[from], kept[to]) = (true, true);
        let distance = |i: usize| beside(on_sheet(i), on_sheet(from), on_sheet(to));
        let farthest = (from + 1..to).map(|i| (i, distance(i))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((middle, _)) = farthest.filter(|(_, distance)| *distance > TOLERANCE) {
            stretches.extend([(from, middle), (middle, to)]);
        }
    }
    points.iter().zip(kept).filter_map(|(point, kept)| kept.then_some(*point)).collect()
}

/// Returns the distance of a point from a line segment.
fn beside(point: Point, from: Point, to: Point) -> f64 {
    let along = (to.0 - from.0, to.1 - from.1);
    let off = (point.0 - from.0, point.1 - from.1);
    let length = along.0 * along.0 + along.1 * along.1;
    let part = if length > 0.0 {
        ((off.0 * along.0 + off.1 * along.1) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (off.0 - part * along.0).hypot(off.1 - part * along.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_corner_stays() {
        let mut points: Vec<Point> = (0..=100).map(|i| (f64::from(i), f64::from(i))).collect();
        assert_eq!(thin(&points, [1.0, 1.0]), [(0.0, 0.0), (100.0, 100.0)]);
        points.extend((1..=100).map(|i| (100.0 + f64::from(i), 100.0)));
        assert_eq!(thin(&points, [1.0, 1.0]), [(0.0, 0.0), (100.0, 100.0), (200.0, 100.0)]);
    }

    #[test]
    fn a_spike_of_one_sample_stays() {
        let mut points: Vec<Point> = (0..1000).map(|i| (0.01 * f64::from(i), 0.0)).collect();
        points[500].1 = 1.0;
        assert!(thin(&points, [1.0, 1.0]).contains(&(5.0, 1.0)));
        // A spike that is too small to be seen is removed.
        assert_eq!(thin(&points, [1.0, 20.0]).len(), 2);
    }
}
