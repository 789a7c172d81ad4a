//! What can be set of the layers, and what a study is told about it.

use crate::foveation::plan::{LayerPlan, optimise, slope_from_quality_index};
use crate::geometry::Cone;
use crate::parameters::{number, text};
use experiments::catalogue::{DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo};
use experiments::display::Display;

/// Detail of the outermost layer: 8,000 triangles an object where the others have 20,000 (Guenter 2012, §6).
const OUTERMOST_DETAIL: f64 = 0.4;

pub(crate) fn info() -> RendererInfo {
    let mut parameters = acuity();
    parameters.extend(parts());
    RendererInfo {
        id: "layers".to_owned(),
        version: 3,
        about: "Two to four eccentricity layers around the gaze, optimised for an acuity line: the outer ones at half \
                rate, jittered and reprojected, all blended smoothly."
            .to_owned(),
        source: "Guenter, Finch, Drucker, Tan, Snyder: Foveated 3D Graphics. ACM TOG 31(6), 2012".to_owned(),
        parameters,
        detail: DetailLaw::Line {
            m: "m".to_owned(),
            omega0: "omega0_deg".to_owned(),
            quality_index: Some("quality_index".to_owned()),
        },
    }
}

/// The acuity line and what is optimised for it.
fn acuity() -> Vec<ParameterSchema> {
    vec![
        ParameterSchema::number(
            "m",
            "°/cycle/°",
            0.0..=1.0,
            0.022,
            "Slope of the acuity line: how fast the detail limit grows with eccentricity.",
        ),
        ParameterSchema::number(
            "omega0_deg",
            "°/cycle",
            0.001..=1.0,
            1.0 / 48.0,
            "Detail limit at the fovea: intercept of the acuity line.",
        ),
        ParameterSchema::number(
            "quality_index",
            "",
            0.0..=100.0,
            0.0,
            "Guenter's quality index j, larger is finer; above 0 it sets the slope to 0.33/j in place of m.",
        ),
        ParameterSchema::choice(
            "restrict_s2",
            &["free", "2"],
            "Sampling factor of the second layer: the optimum, or 2 as in Guenter's user study.",
        ),
        ParameterSchema::choice("layers", &["3", "2", "4"], "How many layers there are."),
    ]
}

/// The parts of the system, each of which can be switched off.
fn parts() -> Vec<ParameterSchema> {
    vec![
        ParameterSchema::choice(
            "half_rate",
            &["on", "off"],
            "Whether layers outside the inner one are drawn in every other frame only, in turn.",
        ),
        ParameterSchema::choice(
            "jitter",
            &["outer", "all", "off"],
            "Which layers are shifted by up to half a pixel of theirs at each drawing: all but the inner one, so that \
             the fovea equals the reference; all, as in the paper; or none. The inner layer is reprojected where it is jittered.",
        ),
        ParameterSchema::choice(
            "reprojection",
            &["on", "off"],
            "Whether a layer is averaged with its own earlier pictures, followed through depth.",
        ),
        ParameterSchema::number(
            "history_weight",
            "",
            0.02..=1.0,
            0.1,
            "Least weight of the newest sample in that average: 0.1 keeps about ten drawings.",
        ),
        ParameterSchema::number(
            "depth_tolerance",
            "",
            0.0..=1.0,
            0.05,
            "How far an earlier pixel's inverse depth may be from what is expected, as a share of it, before it counts \
             as another surface.",
        ),
        ParameterSchema::choice("msaa", &["on", "off"], "Whether edges of geometry are sampled four times a pixel."),
        ParameterSchema::choice(
            "lod",
            &["on", "off"],
            "Whether curved surfaces have fewer triangles in the outermost layer: 8,000 for 20,000.",
        ),
        ParameterSchema::choice(
            "magnification",
            &["bilinear", "nearest"],
            "How a layer's pixels become the display's.",
        ),
        ParameterSchema::choice(
            "blend",
            &["smooth", "hard"],
            "Whether a layer fades into the next from 0.6 of its radius on, or ends at its radius.",
        ),
    ]
}

/// Which layers are jittered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Jitter {
    /// All but the innermost.
    Outer,
    All,
    Off,
}

/// The parameters, read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Settings {
    pub(super) plan: LayerPlan,
    /// The innermost layer that has any pixels with the gaze in the middle of the display.
    fovea: usize,
    pub(super) half_rate: bool,
    jitter: Jitter,
    reprojection: bool,
    pub(super) history_weight: f64,
    pub(super) depth_tolerance: f64,
    pub(super) msaa: bool,
    lod: bool,
    pub(super) bilinear: bool,
    pub(super) smooth: bool,
}

impl Settings {
    /// Reads completed parameters and optimises the layers for `display`.
    pub(super) fn read(display: &Display, parameters: &Parameters) -> Result<Self, Vec<ParameterError>> {
        let on = |name| text(parameters, name).map(|value| value == "on");
        let restrict_s2 = text(parameters, "restrict_s2")?.parse().ok();
        let layers = text(parameters, "layers")?.parse().unwrap_or(3);
        let quality_index = number(parameters, "quality_index")?;
        let m = if quality_index > 0.0 { slope_from_quality_index(quality_index) } else { number(parameters, "m")? };
        let plan = optimise(display, m, number(parameters, "omega0_deg")?, layers, restrict_s2);
        let has_pixels = |radius_deg| Cone::new(display, [0.0; 2], radius_deg).bounds().is_some();
        let fovea = plan.layers.iter().position(|layer| has_pixels(layer.radius_deg)).unwrap_or_default();
        Ok(Self {
            plan,
            fovea,
            half_rate: on("half_rate")?,
            jitter: match text(parameters, "jitter")? {
                "outer" => Jitter::Outer,
                "all" => Jitter::All,
                _ => Jitter::Off,
            },
            reprojection: on("reprojection")?,
            history_weight: number(parameters, "history_weight")?,
            depth_tolerance: number(parameters, "depth_tolerance")?,
            msaa: on("msaa")?,
            lod: on("lod")?,
            bilinear: text(parameters, "magnification")? == "bilinear",
            smooth: text(parameters, "blend")? == "smooth",
        })
    }

    pub(super) fn layers(&self) -> usize {
        self.plan.layers.len()
    }

    /// Whether layer `index` is what the fovea sees: the innermost one that has any pixels and, where a display is so coarse
    /// that the next one has its own sampling too, that one as well.
    pub(super) fn is_inner(&self, index: usize) -> bool {
        index <= self.fovea || self.plan.layers.get(index).is_some_and(|layer| layer.sampling_factor <= 1.0)
    }

    /// Whether layer `index` is drawn in every other frame only.
    pub(super) fn rests(&self, index: usize) -> bool {
        self.half_rate && !self.is_inner(index)
    }

    /// Whether layer `index` is jittered.
    pub(super) fn jitters(&self, index: usize) -> bool {
        match self.jitter {
            Jitter::Outer => !self.is_inner(index),
            Jitter::All => true,
            Jitter::Off => false,
        }
    }

    /// Whether layer `index` is averaged with its earlier pictures.
    pub(super) fn reprojects(&self, index: usize) -> bool {
        self.reprojection && (!self.is_inner(index) || self.jitter == Jitter::All)
    }

    /// Share of the triangles that layer `index` gets.
    pub(super) fn detail(&self, index: usize) -> f64 {
        if self.lod && index + 1 == self.layers() { OUTERMOST_DETAIL } else { 1.0 }
    }

    /// Whether any part makes a picture depend on the frames before.
    pub(super) fn remembers(&self) -> bool {
        self.half_rate || self.reprojection || self.jitter != Jitter::Off
    }
}
