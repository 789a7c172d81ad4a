// Counts, on the GPU, what is shaded: for each draw its pixels and its runs of a shading function, and for each display
// pixel how many of those runs fell on it.

struct Tally {
    // Width and height of the display.
    size: vec2u,
    // Which of the draws is being counted.
    draw: u32,
    reserved: u32,
}

@group(1) @binding(0) var<uniform> tally: Tally;
// Two for each draw: pixels of its target, and runs of the shading function.
@group(1) @binding(1) var<storage, read_write> totals: array<atomic<u32>>;
// One for each display pixel.
@group(1) @binding(2) var<storage, read_write> runs: array<atomic<u32>>;

// Counts one run for the display pixel at `px`.
fn count_run(px: vec2f) {
    atomicAdd(&totals[2u * tally.draw + 1u], 1u);
    let at = vec2i(floor(px));
    if all(at >= vec2i(0)) && all(at < vec2i(tally.size)) {
        atomicAdd(&runs[u32(at.y) * tally.size.x + u32(at.x)], 1u);
    }
}

fn count_pixel() {
    atomicAdd(&totals[2u * tally.draw], 1u);
}
