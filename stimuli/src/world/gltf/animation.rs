//! Animations as motion: each animated node's tracks of translation, rotation and scale (glTF 2.0, §3.11).

use super::accessors::{Accessors, Allowed, Component, FLOATS};
use super::document::{self, Document};
use super::errors::Findings;
use super::nodes::Rest;
use crate::world::channels::{Channels, Interpolation, Track};
use glam::{Quat, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// How each animated node moves, by the node's index.
pub(crate) type Clip = HashMap<usize, Arc<Channels>>;

const TURNS: Allowed = Allowed {
    components: |c, normalised| {
        c == Component::F32
            || (normalised && matches!(c, Component::I8 | Component::U8 | Component::I16 | Component::U16))
    },
    said: "floats or normalised numbers of 8 or 16 bits",
};

/// Times beyond this many seconds are refused.
const MOST_SECONDS: f32 = 1e6;

/// Reads the animation at `place`.
pub(crate) fn clip(
    animation: &document::Animation,
    place: &str,
    document: &Document,
    rests: &[Rest],
    accessors: &Accessors<'_>,
    findings: &mut Findings,
) -> Clip {
    let mut moving: HashMap<usize, Channels> = HashMap::new();
    let mut span_s: f64 = 0.0;
    for (index, channel) in animation.channels.iter().enumerate() {
        let place = format!("{place}.channels[{index}]");
        let Some(node) = channel.target.node else {
            findings.note(place, "it animates something else than a node and is left out");
            continue;
        };
        let (at, turn, scale) = match rests.get(node) {
            Some(Rest::Parts { at, turn, scale }) => (*at, *turn, *scale),
            Some(Rest::Matrix(_)) if document.nodes[node].matrix.is_none() => continue,
            Some(Rest::Matrix(_)) => {
                findings
                    .wrong(place, format!("node {node} has a matrix; only translation, rotation and scale can move"));
                continue;
            }
            None => {
                findings.wrong(
                    format!("{place}.target.node"),
                    format!("there is no node {node}; the file has {}", rests.len()),
                );
                continue;
            }
        };
        let Some(sampler) = animation.samplers.get(channel.sampler) else {
            let count = animation.samplers.len();
            findings.wrong(
                format!("{place}.sampler"),
                format!("there is no sampler {}; the animation has {count}", channel.sampler),
            );
            continue;
        };
        let node = moving.entry(node).or_insert_with(|| Channels {
            rest_at: at,
            rest_turn: turn,
            rest_scale: scale,
            at: None,
            turn: None,
            scale: None,
            span_s: 0.0,
        });
        let keys = Keys { sampler, place: &place, accessors };
        let taken = match channel.target.path.as_str() {
            "translation" => {
                keys.track("VEC3", FLOATS, Vec3::from_array, findings).map(|t| node.at.replace(t).is_some())
            }
            "scale" => keys.track("VEC3", FLOATS, Vec3::from_array, findings).map(|t| node.scale.replace(t).is_some()),
            "rotation" => keys.turns(findings).map(|t| node.turn.replace(t).is_some()),
            "weights" => {
                findings.note(place.as_str(), "weights of morph targets are left out");
                continue;
            }
            path => {
                let path = super::accessors::shown(path);
                findings.wrong(
                    format!("{place}.target.path"),
                    format!("\"{path}\" is none of translation, rotation, scale, weights"),
                );
                continue;
            }
        };
        if taken == Some(true) {
            findings.wrong(place.as_str(), "another channel moves the same property of the same node");
        }
        let ends = [
            node.at.as_ref().map(Track::end_s),
            node.turn.as_ref().map(Track::end_s),
            node.scale.as_ref().map(Track::end_s),
        ];
        span_s = ends.into_iter().flatten().fold(span_s, f64::max);
    }
    // All nodes begin anew together.
    moving.into_iter().map(|(node, channels)| (node, Arc::new(Channels { span_s, ..channels }))).collect()
}

/// A sampler's keys, read for a channel at `place`.
struct Keys<'a> {
    sampler: &'a document::AnimationSampler,
    place: &'a str,
    accessors: &'a Accessors<'a>,
}

impl Keys<'_> {
    fn track<const N: usize, T>(
        &self,
        kind: &str,
        allowed: Allowed,
        made: fn([f32; N]) -> T,
        findings: &mut Findings,
    ) -> Option<Track<T>> {
        let times_at = format!("{}.sampler.input", self.place);
        let times = self.accessors.read::<1>(self.sampler.input, "SCALAR", FLOATS, &times_at, findings)?;
        let times: Vec<f32> = times.into_iter().flatten().collect();
        if let Some(bad) = times.iter().find(|time| !(0.0..=MOST_SECONDS).contains(*time)) {
            findings.wrong(times_at, format!("a time is {bad} s; expected 0 to {MOST_SECONDS} s"));
            return None;
        }
        if let Some(bad) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            let message = format!(
                "times must rise, but {} s is followed by {} s (items {bad} and after)",
                times[bad],
                times[bad + 1]
            );
            findings.wrong(times_at, message);
            return None;
        }
        let (interpolation, each) = match self.sampler.interpolation {
            document::Interpolation::Linear => (Interpolation::Linear, 1),
            document::Interpolation::Step => (Interpolation::Step, 1),
            document::Interpolation::CubicSpline => (Interpolation::Cubic, 3),
        };
        let values_at = format!("{}.sampler.output", self.place);
        let values = self.accessors.read::<N>(self.sampler.output, kind, allowed, &values_at, findings)?;
        if values.len() != each * times.len() {
            let message = format!("it has {} items; expected {each} for each of {} times", values.len(), times.len());
            findings.wrong(values_at, message);
            return None;
        }
        let values = values.into_iter().map(made).collect();
        Some(Track { times_s: times.into_iter().map(f64::from).collect(), values, interpolation })
    }

    /// Turns; the values are made unit quaternions, tangents stay as they are.
    fn turns(&self, findings: &mut Findings) -> Option<Track<Quat>> {
        let mut track = self.track("VEC4", TURNS, Quat::from_array, findings)?;
        let cubic = track.interpolation == Interpolation::Cubic;
        let is_value = |i: usize| !cubic || i % 3 == 1;
        for (i, value) in track.values.iter_mut().enumerate().filter(|(i, _)| is_value(*i)) {
            match glam::Vec4::from(*value).try_normalize() {
                Some(unit) => *value = Quat::from_vec4(unit),
                None => {
                    findings.wrong(
                        format!("{}.sampler.output", self.place),
                        format!("item {i} is a quaternion of length zero"),
                    );
                    return None;
                }
            }
        }
        Some(track)
    }
}
