//! A bounding volume hierarchy: which boxes hold which things, so that a ray meets few of them. Built by the surface area
//! heuristic in bins (Wald 2007), once for the triangles of each mesh and again for the places of the objects.

use glam::Vec3;

/// A node as shaders read it: 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Node {
    /// Lowest corner.
    pub(crate) low: [f32; 3],
    /// Of a leaf its first item; otherwise its first child, whose sibling follows it.
    pub(crate) first: u32,
    /// Highest corner.
    pub(crate) high: [f32; 3],
    /// Items of a leaf; 0 for what has children.
    pub(crate) count: u32,
}

/// A hierarchy over items.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Bvh {
    /// The root comes first; empty without items.
    pub(crate) nodes: Vec<Node>,
    /// The items in the order in which leaves hold them.
    pub(crate) items: Vec<u32>,
}

/// Bins along an axis.
const BINS: usize = 16;
/// What going down a node costs, in tests of items.
const STEP_COST: f32 = 1.0;
/// Depth at which a node becomes a leaf whatever it holds: what the shaders' stacks hold.
pub(crate) const DEEPEST: u32 = 30;

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const NOTHING: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

impl Bvh {
    /// Over boxes, each a lowest and a highest corner; leaves hold at most about `leaf` of them.
    pub(crate) fn over(boxes: &[[Vec3; 2]], leaf: u32) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let bounds: Vec<Bounds> = boxes.iter().map(|&[low, high]| Bounds { low, high }).collect();
        let middles: Vec<Vec3> = boxes.iter().map(|[low, high]| 0.5 * (*low + *high)).collect();
        let mut bvh = Self { nodes: Vec::new(), items: (0..boxes.len() as u32).collect() };
        bvh.nodes.push(leaf_node(0, 0));
        // Each open node with its range of items and its depth.
        let mut open = vec![(0_usize, 0_usize, boxes.len(), 0_u32)];
        while let Some((node, first, end, depth)) = open.pop() {
            let items = &mut bvh.items[first..end];
            let all = items.iter().fold(Bounds::NOTHING, |sum, &item| sum.with(bounds[item as usize]));
            bvh.nodes[node] =
                Node { low: all.low.into(), high: all.high.into(), ..leaf_node(first as u32, (end - first) as u32) };
            if items.len() as u32 <= leaf || depth + 1 >= DEEPEST {
                continue;
            }
            let Some((axis, threshold)) = best_split(items, &bounds, &middles, &all) else { continue };
            let left = partition(items, |&item| middles[item as usize][axis] < threshold);
            if left == 0 || left == items.len() {
                continue;
            }
            let child = bvh.nodes.len();
            bvh.nodes[node].first = child as u32;
            bvh.nodes[node].count = 0;
            bvh.nodes.extend([leaf_node(0, 0); 2]);
            open.push((child, first, first + left, depth + 1));
            open.push((child + 1, first + left, end, depth + 1));
        }
        bvh
    }
}

fn leaf_node(first: u32, count: u32) -> Node {
    Node { low: [0.0; 3], first, high: [0.0; 3], count }
}

/// The axis and place of the cheapest division; nothing where none is cheaper than a leaf or all middles coincide.
fn best_split(items: &[u32], bounds: &[Bounds], middles: &[Vec3], all: &Bounds) -> Option<(usize, f32)> {
    let spread = items.iter().fold(Bounds::NOTHING, |sum, &item| {
        let middle = middles[item as usize];
        sum.with(Bounds { low: middle, high: middle })
    });
    let area = all.half_area().max(f32::MIN_POSITIVE);
    // A leaf of many is divided even where the estimate says that it would not pay.
    let mut best = (if items.len() > 16 { f32::INFINITY } else { items.len() as f32 }, None);
    for (axis, right) in [[0.0; BINS]; 3].iter_mut().enumerate() {
        let (low, size) = (spread.low[axis], spread.high[axis] - spread.low[axis]);
        if size.is_nan() || size <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::NOTHING, 0_u32); BINS];
        for &item in items {
            let bin = (((middles[item as usize][axis] - low) / size * BINS as f32) as usize).min(BINS - 1);
            bins[bin] = (bins[bin].0.with(bounds[item as usize]), bins[bin].1 + 1);
        }
        // `right`: areas times counts of everything right of each border; then of everything left of it.
        let mut sum = (Bounds::NOTHING, 0);
        for i in (1..BINS).rev() {
            sum = (sum.0.with(bins[i].0), sum.1 + bins[i].1);
            right[i] = if sum.1 == 0 { f32::INFINITY } else { sum.0.half_area() * sum.1 as f32 };
        }
        sum = (Bounds::NOTHING, 0);
        for i in 1..BINS {
            sum = (sum.0.with(bins[i - 1].0), sum.1 + bins[i - 1].1);
            if sum.1 == 0 {
                continue;
            }
            let cost = STEP_COST + (sum.0.half_area() * sum.1 as f32 + right[i]) / area;
            if cost < best.0 {
                best = (cost, Some((axis, low + size * i as f32 / BINS as f32)));
            }
        }
    }
    best.1
}

/// Moves what `is_left` to the front and returns how many there are.
fn partition(items: &mut [u32], is_left: impl Fn(&u32) -> bool) -> usize {
    let mut left = 0;
    for i in 0..items.len() {
        if is_left(&items[i]) {
            items.swap(i, left);
            left += 1;
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes scattered by a fixed sequence, some of them alike, one of them huge.
    fn boxes(count: usize) -> Vec<[Vec3; 2]> {
        let value = |i: usize, k: f32| (i as f32 * k).fract();
        let mut boxes: Vec<[Vec3; 2]> = (0..count)
            .map(|i| {
                let at = 10.0 * Vec3::new(value(i, 0.754_877_7), value(i, 0.569_840_3), value(i, 0.438_579));
                [at, at + 0.3 * value(i, 0.618_034)]
            })
            .collect();
        boxes.extend([[Vec3::ONE, Vec3::splat(1.5)]; 40]);
        boxes.push([Vec3::ZERO, Vec3::splat(12.0)]);
        boxes
    }

    #[test]
    fn every_item_is_in_one_leaf_and_inside_all_its_boxes() {
        for count in [0, 1, 2, 5, 3000] {
            let boxes = boxes(count);
            let bvh = Bvh::over(&boxes, 4);
            let mut found = vec![0; boxes.len()];
            let mut open = vec![(0_usize, 0_u32)];
            let mut deepest = 0;
            while let Some((node, depth)) = open.pop() {
                let n = bvh.nodes[node];
                let inside =
                    |low: Vec3, high: Vec3| Vec3::from(n.low).cmple(low).all() && Vec3::from(n.high).cmpge(high).all();
                deepest = deepest.max(depth);
                if n.count == 0 {
                    for child in [n.first as usize, n.first as usize + 1] {
                        let c = bvh.nodes[child];
                        assert!(inside(c.low.into(), c.high.into()));
                        open.push((child, depth + 1));
                    }
                } else {
                    for &item in &bvh.items[n.first as usize..(n.first + n.count) as usize] {
                        let [low, high] = boxes[item as usize];
                        assert!(inside(low, high));
                        found[item as usize] += 1;
                    }
                }
            }
            println!("{count}: {} nodes, depth {deepest}", bvh.nodes.len());
            assert!(found.iter().all(|&times| times == 1));
            assert!(deepest < DEEPEST);
        }
        assert_eq!(Bvh::over(&[], 4), Bvh::default());
    }
}
