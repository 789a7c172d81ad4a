//! Which parts of a picture have been made: a grid of square tiles, each made or not, so that work that does not depend on
//! the gaze is done once, where it is first needed.

use crate::geometry::PixelBox;

/// Side of a tile, in samples: large enough that a draw pays, small enough that little is made in vain.
const TILE: u32 = 32;

/// The tiles of one picture.
#[derive(Debug, Clone)]
pub(crate) struct Tiles {
    size: [u32; 2],
    columns: usize,
    made: Vec<bool>,
}

impl Tiles {
    /// The tiles of a picture of `size` samples, none of them made.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|x| x.div_ceil(TILE) as usize);
        Self { size, columns, made: vec![false; columns * rows] }
    }

    /// Forgets what was made.
    pub(crate) fn clear(&mut self) {
        self.made.fill(false);
    }

    /// The tiles that `wanted` touches and that are not made yet, as boxes that do not overlap; from now on they count as
    /// made. `wanted` lies inside the picture.
    pub(crate) fn take_missing(&mut self, wanted: &[PixelBox]) -> Vec<PixelBox> {
        let mut missing = vec![false; self.made.len()];
        for area in wanted {
            let last = |end: u32| end.div_ceil(TILE) as usize;
            for row in (area.top / TILE) as usize..last(area.bottom) {
                for column in (area.left / TILE) as usize..last(area.right) {
                    let index = row * self.columns + column;
                    missing[index] |= !self.made[index];
                }
            }
        }

        // Neighbours in a row of tiles become one box.
        let mut boxes = Vec::new();
        for (row, missing) in missing.chunks(self.columns).enumerate() {
            let mut column = 0;
            for run in missing.chunk_by(|a, b| a == b) {
                let (first, end) = (column, column + run.len());
                column = end;
                if run[0] {
                    self.made[row * self.columns + first..row * self.columns + end].fill(true);
                    let edge = |tile: usize, axis: usize| (tile as u32 * TILE).min(self.size[axis]);
                    boxes.push(PixelBox {
                        left: edge(first, 0),
                        top: edge(row, 1),
                        right: edge(end, 0),
                        bottom: edge(row + 1, 1),
                    });
                }
            }
        }
        boxes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wanted_sample_is_made_exactly_once() {
        let size = [3 * TILE + 5, 2 * TILE];
        let mut tiles = Tiles::new(size);
        let mut made = vec![0; (size[0] * size[1]) as usize];
        let wanted = [
            PixelBox { left: 0, top: 0, right: 1, bottom: 1 },
            PixelBox { left: TILE - 1, top: 3, right: 3 * TILE + 5, bottom: TILE + 1 },
            PixelBox { left: 40, top: TILE, right: 41, bottom: 2 * TILE },
            PixelBox { left: 2, top: 5, right: 3, bottom: 6 },
        ];
        for area in wanted {
            for drawn in tiles.take_missing(&[area]) {
                for y in drawn.top..drawn.bottom {
                    for x in drawn.left..drawn.right {
                        made[(y * size[0] + x) as usize] += 1;
                    }
                }
            }
            for y in area.top..area.bottom {
                for x in area.left..area.right {
                    assert_eq!(made[(y * size[0] + x) as usize], 1, "{x} {y}");
                }
            }
        }
        assert!(made.iter().all(|&times| times <= 1));
        assert!(tiles.take_missing(&wanted).is_empty());
        tiles.clear();
        assert!(!tiles.take_missing(&wanted).is_empty());
    }
}
