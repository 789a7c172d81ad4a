//! The display of a study, and what can be shown on it around the fixation mark.

use crate::display::{CHANNELS, Display, NAMED_DISPLAYS, Transfer, TransferError};
use crate::study::draft::{DisplayChoice, DisplayDraft, TransferDraft};
use crate::study::mistakes::{Report, suggestion};
use crate::study::source::Field;

/// The smallest share of a ring that must be on the display for its eccentricity to be asked about.
pub(super) const LEAST_VISIBLE_SHARE: f64 = 0.25;

/// The display that counts: the override if there is one, else the study's own.
pub(super) fn chosen(
    draft: Option<&DisplayChoice>,
    overriding: Option<&Display>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Display> {
    let before = report.count();
    let own = match draft {
        // A name that only the override's file knows is fine: it is not looked up.
        Some(DisplayChoice::Named(_)) | None if overriding.is_some() => None,
        Some(DisplayChoice::Named(name)) => named(name, field, report),
        Some(DisplayChoice::Described(draft)) => described(draft, field, report),
        None => {
            if !report.has(field) {
                report.at(
                    field,
                    format!(
                        "expected a display, here or as --display: one of {} or an object with name, resolution_px, \
                         size_mm, distance_mm; found none",
                        NAMED_DISPLAYS.join(", ")
                    ),
                );
            }
            None
        }
    };
    match overriding {
        Some(display) => (report.count() == before).then(|| display.clone()),
        None => own,
    }
}

fn named(name: &str, field: &Field, report: &mut Report<'_>) -> Option<Display> {
    let display = Display::named(name);
    if display.is_none() {
        let hint = suggestion(name, NAMED_DISPLAYS);
        let known = NAMED_DISPLAYS.join(", ");
        report
            .at(field, format!("expected one of the displays {known}, or a display's geometry, found {name:?}{hint}"));
    }
    display
}

/// A display from its geometry, reporting what is impossible about it.
pub(in crate::study) fn described(draft: &DisplayDraft, field: &Field, report: &mut Report<'_>) -> Option<Display> {
    let transferred = match &draft.transfer {
        Some(given) => transfer(given, &field.key("transfer"), report),
        None => Some(Transfer::Srgb),
    };
    let mut display = match Display::new(draft.name.clone()?, draft.resolution_px?, draft.size_mm?, draft.distance_mm?)
    {
        Ok(display) => display,
        Err(errors) => {
            for error in errors {
                report.at(&field.key(error.field), format!("expected {}, found {}", error.expected, error.found));
            }
            return None;
        }
    };
    let refreshed = draft.refresh_hz.map_or(Ok(display.clone()), |hz| display.clone().with_refresh_hz(hz));
    let lit = refreshed.and_then(|d| draft.peak_cd_m2.map_or(Ok(d.clone()), |peak| d.clone().with_peak_cd_m2(peak)));
    match lit {
        Ok(complete) => display = complete,
        Err(error) => {
            report.at(&field.key(error.field), format!("expected {}, found {}", error.expected, error.found));
            return None;
        }
    }
    Some(display.with_transfer(transferred?))
}

/// A transfer, reporting everything that is wrong with it.
fn transfer(draft: &TransferDraft, field: &Field, report: &mut Report<'_>) -> Option<Transfer> {
    let tables = [("levels", &draft.levels), ("red", &draft.red), ("green", &draft.green), ("blue", &draft.blue)];
    // What was reported already is there, only wrong.
    let missing = |key: &str, given: bool| !given && !report.has(&field.key(key));
    let missing_tables: Vec<&str> =
        tables.iter().filter(|(key, list)| missing(key, list.is_some())).map(|(key, _)| *key).collect();
    let (has_gamma, has_table) = (!missing("gamma", draft.gamma.is_some()), missing_tables.len() < tables.len());
    match (has_gamma, has_table) {
        (true, true) => {
            report.at(field, "expected either gamma or levels with red, green and blue, found both");
            return None;
        }
        (false, false) => {
            report.at(field, "expected gamma, or levels with red, green and blue, found neither");
            return None;
        }
        (true, false) => return reported(Transfer::gamma(draft.gamma?), field, report),
        (false, true) => {}
    }
    for key in &missing_tables {
        let what = if CHANNELS.contains(key) { "luminances" } else { "levels" };
        report.at(&field.key(key), format!("expected a list of {what} beside the others, found no such key"));
    }
    // A value that does not fit was reported, and without it the rest cannot be judged.
    let whole = |list: &Option<Vec<Option<f64>>>| list.as_ref()?.iter().copied().collect::<Option<Vec<f64>>>();
    let (levels, red, green, blue) =
        (whole(&draft.levels)?, whole(&draft.red)?, whole(&draft.green)?, whole(&draft.blue)?);
    reported(Transfer::measured(levels, [red, green, blue]), field, report)
}

fn reported(made: Result<Transfer, Vec<TransferError>>, field: &Field, report: &mut Report<'_>) -> Option<Transfer> {
    match made {
        Ok(transfer) => Some(transfer),
        Err(errors) => {
            for error in errors {
                let key = field.key(error.key);
                let place = error.index.map_or_else(|| key.clone(), |index| key.item(index));
                report.at(&place, format!("expected {}, found {}", error.expected, error.found));
            }
            None
        }
    }
}

/// A display and where on it observers look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Geometry<'a> {
    pub(super) display: &'a Display,
    pub(super) fixation_deg: [f64; 2],
}

impl Geometry<'_> {
    /// Reports an eccentricity whose ring is not on the display, and says whether it is.
    pub(super) fn ring_is_visible(&self, eccentricity_deg: f64, field: &Field, report: &mut Report<'_>) -> bool {
        let share = self.display.visible_share(self.fixation_deg, eccentricity_deg);
        if share < LEAST_VISIBLE_SHARE {
            report.at(
                field,
                format!(
                    "expected an eccentricity whose ring is on the display \"{}\" for at least {:.0} % of its \
                     circumference (up to {:.1}° here), found {eccentricity_deg}° with {:.0} %",
                    self.display.name(),
                    100.0 * LEAST_VISIBLE_SHARE,
                    self.largest_eccentricity_deg(),
                    100.0 * share
                ),
            );
        }
        share >= LEAST_VISIBLE_SHARE
    }

    /// The finest MAR that can be shown at an eccentricity, in degrees per cycle.
    pub(super) fn finest_mar_deg(&self, eccentricity_deg: f64) -> f64 {
        finest_mar_around(self.display, self.fixation_deg, eccentricity_deg)
    }

    /// The largest eccentricity whose ring counts as visible, in degrees, to a tenth.
    fn largest_eccentricity_deg(&self) -> f64 {
        let is_visible = |tenths: &u32| {
            self.display.visible_share(self.fixation_deg, f64::from(*tenths) / 10.0) >= LEAST_VISIBLE_SHARE
        };
        f64::from((0..900).rev().find(is_visible).unwrap_or(0)) / 10.0
    }
}

/// The finest MAR, in degrees per cycle, that `display` can show at an eccentricity around `fixation_deg`.
///
/// Taken at the place on the horizontal through the fixation mark, towards the farther side of the display: a ring
/// leaves the display there last, and off the axis a flat display's pixels look smaller. Meant for eccentricities whose
/// ring meets the display; beyond it the plane of the display is continued.
#[must_use]
pub fn finest_mar_around(display: &Display, fixation_deg: [f64; 2], eccentricity_deg: f64) -> f64 {
    let gaze = display.direction_from_mm(display.mm_from_deg(fixation_deg));
    let across = (gaze[0] * gaze[0] + gaze[2] * gaze[2]).sqrt();
    let slant = (across * across + gaze[1] * gaze[1]).sqrt();
    let side = if fixation_deg[0] > 0.0 { -1.0 } else { 1.0 };
    let (sin_e, cos_e) = eccentricity_deg.to_radians().sin_cos();
    // The gaze turned about the observer's own vertical: `right` is horizontal and at right angles to it.
    let right = [side * gaze[2] / across, 0.0, -side * gaze[0] / across];
    let direction: [f64; 3] = std::array::from_fn(|i| gaze[i] / slant * cos_e + right[i] * sin_e);
    let scale = display.distance_mm() / direction[2];
    display.finest_mar_deg(display.deg_from_mm([direction[0] * scale, direction[1] * scale]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finest_mar_is_taken_at_the_true_angle() {
        let display = Display::named("guenter-2012").expect("ships");
        for fixation_deg in [[0.0, 0.0], [-5.0, 3.0], [6.0, -2.0]] {
            assert!(
                (finest_mar_around(&display, fixation_deg, 0.0) - display.finest_mar_deg(fixation_deg)).abs() < 1e-12
            );
        }
        // From the centre, along the horizontal, the eccentricity is the place's own angle.
        let at_ten = display.finest_mar_deg([10.0, 0.0]);
        assert!((finest_mar_around(&display, [0.0, 0.0], 10.0) - at_ten).abs() < 1e-12);
        // From a mark on the right, the farther side is the left, and mirrored marks see the same.
        let mirrored = [finest_mar_around(&display, [6.0, 1.0], 9.0), finest_mar_around(&display, [-6.0, 1.0], 9.0)];
        assert!((mirrored[0] - mirrored[1]).abs() < 1e-12);
    }
}
