//! How well one quantity follows another.

/// Pearson's correlation: 1 where `y` rises with `x` along a line. None with fewer than two pairs, or where either is
/// constant.
pub fn pearson(x: &[f64], y: &[f64]) -> Option<f64> {
    assert_eq!(x.len(), y.len(), "pairs");
    if x.len() < 2 {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (dx, dy) = (x - mean_x, y - mean_y);
        xx += dx * dx;
        yy += dy * dy;
        xy += dx * dy;
    }
    let r = xy / (xx * yy).sqrt();
    r.is_finite().then(|| r.clamp(-1.0, 1.0))
}

/// Spearman's rank correlation: 1 where `y` never falls as `x` rises, along whatever curve. None as for [`pearson`].
pub fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    pearson(&ranks(x), &ranks(y))
}

/// Ranks from 0; equal values share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let rank = first as f64 + (equal.len() - 1) as f64 / 2.0;
        equal.iter().for_each(|&i| ranks[i] = rank);
        first += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_data_has_its_known_correlation() {
        // By hand: deviations -2..2 and -1.2, -2.2, 0.8, -0.2, 2.8; sums 10, 14.8 and 10.
        let (x, y) = ([1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 1.0, 4.0, 3.0, 6.0]);
        assert!((pearson(&x, &y).unwrap() - 10.0 / 148.0_f64.sqrt()).abs() < 1e-12);
        // 1 - 6 sum d^2 / (n (n^2 - 1)), with four ranks off by one.
        assert!((spearman(&x, &y).unwrap() - (1.0 - 24.0 / 120.0)).abs() < 1e-12);
        let line: Vec<f64> = x.iter().map(|x| 7.0 - 2.0 * x).collect();
        assert!((pearson(&x, &line).unwrap() + 1.0).abs() < 1e-12);
    }

    #[test]
    fn ranks_follow_any_rising_curve_and_share_ties() {
        let x: Vec<f64> = (0..40).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| (0.5 * x).exp()).collect();
        assert!((spearman(&x, &y).unwrap() - 1.0).abs() < 1e-12);
        assert!(pearson(&x, &y).unwrap() < 0.7, "a curve is no line");
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 0.0]), [2.5, 1.0, 2.5, 0.0]);
    }

    #[test]
    fn a_wrong_order_is_noticed() {
        let x: Vec<f64> = (0..101).map(f64::from).collect();
        // The same values in another order: 37 is coprime to 101, so it visits each once.
        let shuffled: Vec<f64> = (0..101).map(|i| f64::from(i * 37 % 101)).collect();
        let reversed: Vec<f64> = x.iter().rev().copied().collect();
        for correlation in [pearson, spearman] {
            assert!((correlation(&x, &x).unwrap() - 1.0).abs() < 1e-12);
            assert!(correlation(&x, &shuffled).unwrap().abs() < 0.3);
            assert!((correlation(&x, &reversed).unwrap() + 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_does_not_vary_has_none() {
        for correlation in [pearson, spearman] {
            assert_eq!(correlation(&[], &[]), None);
            assert_eq!(correlation(&[1.0], &[2.0]), None);
            assert_eq!(correlation(&[1.0, 1.0], &[2.0, 3.0]), None);
        }
    }
}
