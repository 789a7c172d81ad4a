//! `parafovea predict`: what foveated rendering with eccentricity layers saves on a display, for an acuity slope.

use super::{inputs, print, print_json};
use crate::error::LabError;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use stimuli::foveation::plan::{LayerPlan, optimise, slope_from_quality_index};

/// Foveal MAR of the average adult below 50 (Guenter 2012, §3): 48 cycles per degree.
const OMEGA0_DEG: f64 = 1.0 / 48.0;

#[derive(Debug, Args)]
pub(super) struct PredictArgs {
    /// MAR slope: degrees per cycle gained by each degree of eccentricity.
    #[arg(long, required_unless_present = "quality", value_parser = slope)]
    m: Option<f64>,
    /// Guenter's quality index j instead of a slope (m = 0.33 / j).
    #[arg(long, value_name = "J", conflicts_with = "m", value_parser = quality)]
    quality: Option<f64>,
    /// MAR at the fovea in degrees per cycle.
    #[arg(long, default_value_t = OMEGA0_DEG, value_parser = slope)]
    omega0: f64,
    /// The display, by name or file.
    #[arg(long, value_name = "NAME|FILE")]
    display: String,
    /// Number of eccentricity layers.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=4))]
    layers: u8,
    /// Restrict the second layer to this sampling factor, as Guenter's study did with 2.
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    s2: Option<f64>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

fn number_between(text: &str, min: f64, max: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (min..=max).contains(&value) => Ok(value),
        _ => Err(format!("expected a number from {min} to {max}")),
    }
}

fn slope(text: &str) -> Result<f64, String> {
    number_between(text, 1e-4, 10.0)
}

fn quality(text: &str) -> Result<f64, String> {
    number_between(text, 0.1, 1000.0)
}

fn factor(text: &str) -> Result<f64, String> {
    number_between(text, 1.0, 100.0)
}

#[derive(Debug, Serialize)]
struct Prediction {
    display: String,
    m: f64,
    omega0_deg: f64,
    e_star_deg: f64,
    omega_star_deg: f64,
    display_pixels: f64,
    layers: Vec<LayerOut>,
    speedup: f64,
    speedup_half_rate: f64,
}

#[derive(Debug, Serialize)]
struct LayerOut {
    radius_deg: f64,
    sampling_factor: f64,
    pixels: f64,
}

pub(super) fn run(args: &PredictArgs) -> Result<(), LabError> {
    let display =
        inputs::display(Some(&args.display))?.ok_or_else(|| LabError::BadInput("--display is required".to_owned()))?;
    let m = args.m.or(args.quality.map(slope_from_quality_index)).unwrap_or_default();
    let plan = optimise(&display, m, args.omega0, usize::from(args.layers), args.s2);
    let prediction = prediction(display.name(), &plan);
    if args.json { print_json(&prediction) } else { print(&text(&prediction)) }
}

fn prediction(display: &str, plan: &LayerPlan) -> Prediction {
    Prediction {
        display: display.to_owned(),
        m: plan.m,
        omega0_deg: plan.omega0_deg,
        e_star_deg: plan.geometry.e_star_deg,
        omega_star_deg: plan.geometry.omega_star_deg,
        display_pixels: plan.geometry.display_pixels(),
        layers: plan
            .layers
            .iter()
            .map(|layer| LayerOut {
                radius_deg: layer.radius_deg,
                sampling_factor: layer.sampling_factor,
                pixels: layer.pixels,
            })
            .collect(),
        speedup: plan.speedup(),
        speedup_half_rate: plan.speedup_half_rate(),
    }
}

fn text(prediction: &Prediction) -> String {
    let mut text = format!(
        "{}: half field {:.3}°, sharpness {:.5}° per cycle, {:.0} pixels\nacuity line: omega = {:.4} e + {:.5}\n\n  \
         layer   radius (°)   sampling factor      pixels\n",
        prediction.display,
        prediction.e_star_deg,
        prediction.omega_star_deg,
        prediction.display_pixels,
        prediction.m,
        prediction.omega0_deg
    );
    for (index, layer) in prediction.layers.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:>5}   {:>10.3}   {:>15.3}   {:>9.0}",
            index + 1,
            layer.radius_deg,
            layer.sampling_factor,
            layer.pixels
        );
    }
    let _ = write!(
        text,
        "\npixels of the display over pixels of all layers:  {:.2}\nthe same with the outer layers at half rate:      {:.2}",
        prediction.speedup, prediction.speedup_half_rate
    );
    text
}
