//! Where in its pixels a layer is sampled: whole-frame jitter of half a pixel to either side (Guenter et al. 2012, §4.2,
//! after Cook, Porter and Carpenter 1984). The paper does not say in which order; ours repeats after sixteen drawings.

/// Drawings after which the places repeat.
pub(super) const PERIOD: u64 = 16;

/// The place of drawing `update`, in pixels from the pixel's middle, −½ to ½ on each axis.
///
/// The first sixteen points of Sobol's two-dimensional sequence, each in the middle of its sixteenth: every strip of a
/// sixteenth of the pixel along either axis, and every one of 4 × 4 squares, holds exactly one, so that their mean is the
/// pixel's middle.
pub(super) fn offset(update: u64) -> [f64; 2] {
    let index = (update % PERIOD) as u32;
    // Bits reversed, and the second dimension's direction numbers.
    let x = (0..4).filter(|bit| index >> bit & 1 == 1).fold(0, |sum, bit| sum ^ (8 >> bit));
    let y = (0..4).zip([8, 12, 10, 15]).filter(|(bit, _)| index >> bit & 1 == 1).fold(0, |sum, (_, v)| sum ^ v);
    [x, y].map(|cell: u32| (f64::from(cell) + 0.5) / PERIOD as f64 - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_strip_and_every_square_holds_one() {
        let points: Vec<[f64; 2]> = (0..PERIOD).map(offset).collect();
        for (across, down) in [(16, 1), (1, 16), (4, 4), (8, 2), (2, 8)] {
            let mut counts = vec![0; 16];
            for [x, y] in &points {
                let cell = |at: f64, cells: usize| ((at + 0.5) * cells as f64) as usize;
                counts[cell(*y, down) * across + cell(*x, across)] += 1;
            }
            assert!(counts.iter().all(|&count| count == 1), "{across}×{down}: {counts:?}");
        }
        for axis in 0..2 {
            assert!(points.iter().map(|point| point[axis]).sum::<f64>().abs() < 1e-12);
            assert!(points.iter().all(|point| point[axis].abs() < 0.5));
        }
        assert_eq!(offset(3), offset(3 + PERIOD));
    }

    /// Any four in a row are spread over the pixel's quarters: a short history is balanced too.
    #[test]
    fn four_in_a_row_lie_in_four_quarters() {
        for first in (0..PERIOD).step_by(4) {
            let mut quarters: Vec<_> = (first..first + 4).map(|i| offset(i).map(|x| x > 0.0)).collect();
            quarters.sort_unstable();
            quarters.dedup();
            assert_eq!(quarters.len(), 4, "from {first}");
        }
    }
}
