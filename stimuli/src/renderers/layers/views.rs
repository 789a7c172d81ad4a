//! What each layer shows of the display, and in which frames it is drawn: views around the gaze that are clamped to the
//! display and lie on grids fixed to it, and the stagger of Guenter et al. 2012, §4.

use super::settings::Settings;
use crate::contract::View;
use crate::geometry::{Cone, PixelBox};
use experiments::display::Display;

/// Layer pixels by which a layer that rests in every other frame reaches past its circle, so that a gaze that drifts or
/// pursues does not leave it in between. Two pixels of the paper's middle layer are 25°/s at 120 Hz.
const RESTING_MARGIN: f64 = 2.0;

/// Names of the layers, innermost first.
pub(super) fn names(layers: usize) -> &'static [&'static str] {
    match layers {
        2 => &["inner", "outer"],
        3 => &["inner", "middle", "outer"],
        _ => &["inner", "middle", "far middle", "outer"],
    }
}

/// Display pixels that layer `index` has to show with the gaze at `gaze_deg`: the box around its circle, or the whole
/// display for the outermost one. `None` where the circle does not touch the display.
pub(super) fn needed(display: &Display, settings: &Settings, index: usize, gaze_deg: [f64; 2]) -> Option<PixelBox> {
    let layer = settings.plan.layers.get(index)?;
    if index + 1 == settings.layers() {
        let [right, bottom] = display.resolution_px();
        return Some(PixelBox { left: 0, top: 0, right, bottom });
    }
    Cone::new(display, gaze_deg, layer.radius_deg).bounds()
}

/// The view in which layer `index` shows `needed` when it is drawn.
pub(super) fn view(display: &Display, settings: &Settings, index: usize, needed: PixelBox) -> View {
    let sampling_factor = settings.plan.layers.get(index).map_or(1.0, |layer| layer.sampling_factor);
    let margin = if settings.rests(index) { (RESTING_MARGIN * sampling_factor).ceil() as u32 } else { 0 };
    let [width, height] = display.resolution_px();
    let reach = PixelBox {
        left: needed.left.saturating_sub(margin),
        top: needed.top.saturating_sub(margin),
        right: needed.right.saturating_add(margin).min(width),
        bottom: needed.bottom.saturating_add(margin).min(height),
    };
    on_grid(reach, sampling_factor)
}

/// The view that holds `bounds`, on a grid that is fixed to the display so that it does not swim with the gaze, and that
/// pictures of different gazes lie on each other.
///
/// It reaches past the display's edges by less than one of its pixels.
fn on_grid(bounds: PixelBox, sampling_factor: f64) -> View {
    let span = |first: u32, end: u32| {
        let low = (f64::from(first) / sampling_factor).floor();
        let high = (f64::from(end) / sampling_factor).ceil();
        (low * sampling_factor, (high - low).max(1.0))
    };
    let (left, columns) = span(bounds.left, bounds.right);
    let (top, rows) = span(bounds.top, bounds.bottom);
    View {
        origin_px: [left, top],
        size_px: [columns * sampling_factor, rows * sampling_factor],
        target_px: [columns as u32, rows as u32],
    }
}

/// Whether all of `needed` lies in `view`.
pub(super) fn covers(view: &View, needed: PixelBox) -> bool {
    let first = [needed.left, needed.top];
    let end = [needed.right, needed.bottom];
    // Rounding of an edge on the grid is far below a hundredth of a pixel.
    let slack = 0.01;
    (0..2).all(|axis| {
        let (low, high) = (view.origin_px[axis], view.origin_px[axis] + view.size_px[axis]);
        low <= f64::from(first[axis]) + slack && high >= f64::from(end[axis]) - slack
    })
}

/// Whether it is the turn of layer `index` in frame `frame` since the beginning: the inner layer in every frame, the
/// outermost in odd ones, the one inside it in even ones, and so on inwards.
pub(super) fn due(layers: usize, index: usize, frame: u64) -> bool {
    let inwards = layers.saturating_sub(index + 1) as u64;
    index == 0 || (frame + inwards) % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::renderers::layers::info;
    use experiments::catalogue::{Parameters, complete_parameters};

    /// In every pair of frames each layer has its turn, and the middle and outer layer of three never have it together.
    #[test]
    fn turns_alternate() {
        for layers in 2..=4 {
            for frame in 1..9 {
                assert!(due(layers, 0, frame));
                for index in 1..layers {
                    assert_ne!(due(layers, index, frame), due(layers, index, frame + 1));
                }
            }
        }
        assert!(due(3, 1, 2) && !due(3, 2, 2) && due(3, 2, 3) && !due(3, 1, 3));
    }

    /// Whatever the gaze: the view covers what is needed, keeps to the display but for less than one of its pixels, and
    /// its corner lies on the display's grid.
    #[test]
    fn views_hold_what_they_must_and_stay_on_the_display() {
        let display = Display::named("guenter-2012").expect("ships");
        let parameters = complete_parameters(&info().parameters, &Parameters::new()).expect("defaults");
        let settings = Settings::read(&display, &parameters).expect("defaults");
        let mut untouched = 0;
        for step in 0..400 {
            let angle = 0.7 * f64::from(step);
            let gaze_deg = [0.08 * f64::from(step) * angle.cos(), 0.06 * f64::from(step) * angle.sin()];
            for index in 0..3 {
                let Some(needed) = needed(&display, &settings, index, gaze_deg) else {
                    untouched += 1;
                    continue;
                };
                let view = view(&display, &settings, index, needed);
                assert!(covers(&view, needed), "{gaze_deg:?} {index}: {view:?} {needed:?}");
                for (axis, step) in view.step_px().into_iter().enumerate() {
                    let end = view.origin_px[axis] + view.size_px[axis];
                    assert!(view.origin_px[axis] >= 0.0);
                    assert!(end < f64::from(display.resolution_px()[axis]) + step);
                    let cells = view.origin_px[axis] / step;
                    assert!((cells - cells.round()).abs() < 1e-6, "{cells}");
                }
            }
        }
        println!("{untouched} circles of 800 did not touch the display");
        assert!(untouched > 50);
    }
}
