//! Balanced Latin squares (Williams 1949): every level comes once at every place, and follows every other equally often.

/// Row `row` of the square for `n` levels: in which order they come. Rows repeat after [`rows`].
///
/// An even number of levels needs n rows, an odd one 2 n, the second half being the first read backwards; only then is
/// every pair of neighbours equally frequent.
#[must_use]
pub fn row(n: usize, row: usize) -> Vec<usize> {
    if n == 0 {
        return Vec::new();
    }
    let row = row % rows(n);
    let start = row % n;
    let mut order: Vec<usize> = (0..n)
        .map(|place| {
            // 0, 1, n − 1, 2, n − 2, …
            let step = place.div_ceil(2);
            let offset = if place % 2 == 1 { step } else { (n - step) % n };
            (start + offset) % n
        })
        .collect();
    if row >= n {
        order.reverse();
    }
    order
}

/// How many rows a balanced square of `n` levels has.
#[must_use]
pub fn rows(n: usize) -> usize {
    if n.is_multiple_of(2) { n } else { 2 * n }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_every_place_and_every_neighbour_equally_often() {
        for n in 1..=9 {
            let mut places = vec![vec![0; n]; n];
            let mut neighbours = vec![vec![0; n]; n];
            for index in 0..rows(n) {
                let order = row(n, index);
                order.iter().enumerate().for_each(|(place, &level)| places[level][place] += 1);
                order.windows(2).for_each(|pair| neighbours[pair[0]][pair[1]] += 1);
            }
            assert!(places.iter().flatten().all(|&count| count == rows(n) / n), "{n}: {places:?}");
            for (a, counts) in neighbours.iter().enumerate() {
                for (b, &count) in counts.iter().enumerate() {
                    assert_eq!(count, if a == b { 0 } else { rows(n) / n }, "{n}: {a} before {b}");
                }
            }
        }
    }

    /// The square of four treatments as Williams printed it, up to the names of the treatments.
    #[test]
    fn four_levels_give_the_published_square() {
        let square: Vec<Vec<usize>> = (0..4).map(|index| row(4, index)).collect();
        assert_eq!(square, [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]);
    }

    #[test]
    fn rows_start_again_after_the_last() {
        assert_eq!(row(5, 10), row(5, 0));
        assert_eq!(row(4, 7), row(4, 3));
        assert_eq!(row(0, 3), Vec::<usize>::new());
    }
}
