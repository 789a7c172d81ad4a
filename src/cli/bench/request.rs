//! From the options of `parafovea bench renderers` to what is to be measured, or everything that is wrong with them.

use super::RenderersArgs;
use crate::bench::{Entrant, GazePath, REFERENCE, Request, WARM_UP_FRAMES};
use crate::cli::{inputs, settings};
use crate::error::LabError;
use crate::session::SessionFolder;
use crate::stage::launch::gaze_of;
use experiments::catalogue::{
    Catalogue, DetailLaw, ParameterSchema, ParameterValue, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::{Display, DisplayError};
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;

/// Frames that may be asked for.
const FRAMES: RangeInclusive<u32> = 1..=10_000;
/// Frames a second that may be asked for.
const FPS: RangeInclusive<f64> = 1.0..=1000.0;

/// What is to be measured.
///
/// # Errors
/// One message with every mistake.
pub(super) fn read(args: &RenderersArgs) -> Result<Request, LabError> {
    let mut mistakes = Mistakes::default();
    let known = stimuli::catalogue();
    let display = display(args, &mut mistakes);
    let frames = mistakes.number("--frames", &args.frames, &FRAMES);
    let fps = mistakes.number("--fps", &args.fps, &FPS);
    // A gaze file is read all the same where it cannot be said how much of it is needed.
    let needed_s = frames.zip(fps).map_or(0.0, |(frames, fps)| f64::from(WARM_UP_FRAMES + frames - 1) / fps);
    let gaze = display.as_ref().and_then(|display| gaze(&args.gaze, display, needed_s, &mut mistakes));
    let (of_scene, of_renderers) = assignments(args, &mut mistakes);
    let scene_parameters = scene_parameters(args, &known, &of_scene, &mut mistakes);
    let entrants = entrants(args, &known, &of_renderers, &mut mistakes);
    if let Some(path) = &args.figure {
        mistakes.add_if(args.quality.is_empty(), || {
            "--figure: expected --quality too, since it is drawn over it".to_owned()
        });
        mistakes.add_if(!can_be_written(path), || {
            format!("--figure {}: expected a file in a folder that exists", path.display())
        });
    }
    match (display, frames, fps, gaze, scene_parameters) {
        (Some(display), Some(frames), Some(fps), Some(gaze), Some(scene_parameters)) if mistakes.none() => {
            Ok(Request { display, scene: args.scene.clone(), scene_parameters, entrants, frames, fps, gaze })
        }
        _ => Err(mistakes.error()),
    }
}

/// What is wrong, one line each.
#[derive(Debug, Default)]
struct Mistakes(Vec<String>);

impl Mistakes {
    fn none(&self) -> bool {
        self.0.is_empty()
    }

    fn add(&mut self, mistake: String) {
        self.0.push(mistake);
    }

    fn add_if(&mut self, wrong: bool, mistake: impl FnOnce() -> String) {
        if wrong {
            self.0.push(mistake());
        }
    }

    /// A number within `range`.
    fn number<T: FromStr + PartialOrd + std::fmt::Display>(
        &mut self,
        option: &str,
        text: &str,
        range: &RangeInclusive<T>,
    ) -> Option<T> {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        let whole = if T::from_str("0.5").is_ok() { "number" } else { "whole number" };
        self.add_if(number.is_none(), || {
            format!("{option} {text}: expected a {whole} from {} to {}", range.start(), range.end())
        });
        number
    }

    /// All of them as one message.
    fn error(&self) -> LabError {
        match self.0.as_slice() {
            [one] if !one.contains('\n') => LabError::BadInput(one.clone()),
            all => LabError::BadInput(format!("{} mistakes, nothing was done\n{}", all.len(), all.join("\n"))),
        }
    }
}

fn display(args: &RenderersArgs, mistakes: &mut Mistakes) -> Option<Display> {
    let display = match inputs::display(Some(&args.display)) {
        Ok(display) => display,
        Err(error) => {
            mistakes.add(error.to_string());
            None
        }
    };
    let Some(text) = &args.size else { return display };
    let size = settings::size(text);
    if let Err(expected) = &size {
        mistakes.add(format!("--size {text}: {expected}"));
    }
    let (display, size) = (display?, size.ok()?);
    let resized = Display::new(display.name(), size, display.size_mm(), display.distance_mm());
    let wrong = |error: &DisplayError| format!("--size {text}: expected {}, found {}", error.expected, error.found);
    resized.map_err(|errors| errors.iter().for_each(|error| mistakes.add(wrong(error)))).ok()
}

fn gaze(text: &str, display: &Display, needed_s: f64, mistakes: &mut Mistakes) -> Option<GazePath> {
    if let Some(file) = text.strip_prefix("recorded:") {
        let said = |error: LabError| vec![error.to_string()];
        let path = if Path::new(file).is_dir() {
            let gaze = SessionFolder::open(Path::new(file)).and_then(|session| gaze_of(&session, display));
            gaze.map_err(said).and_then(|gaze| GazePath::played_back(file, gaze, display, needed_s))
        } else {
            let text = inputs::read_text(file).map_err(said);
            text.and_then(|text| GazePath::recorded(file, &text, display, needed_s))
        };
        return path.map_err(|found| found.into_iter().for_each(|mistake| mistakes.add(mistake))).ok();
    }
    match text {
        "centre" => Some(GazePath::centre()),
        "sweep" => Some(GazePath::sweep(display)),
        _ => {
            mistakes.add(format!("--gaze {text}: expected sweep, centre or recorded:SESSION|FILE"));
            None
        }
    }
}

/// Parameters of the scene and of the renderers.
fn assignments(args: &RenderersArgs, mistakes: &mut Mistakes) -> (Parameters, Parameters) {
    let mut read = Vec::new();
    for text in &args.set {
        match settings::assignment(text) {
            Ok(assignment) => read.push(assignment),
            Err(expected) => mistakes.add(format!("--set {text}: {expected}")),
        }
    }
    settings::of_scene_and_renderer(&read)
}

fn scene_parameters(
    args: &RenderersArgs,
    known: &Catalogue,
    given: &Parameters,
    mistakes: &mut Mistakes,
) -> Option<Parameters> {
    let Some(scene) = known.scene(&args.scene) else {
        let names: Vec<&str> = known.scenes.iter().map(|scene| scene.id.as_str()).collect();
        mistakes.add(format!("--scene {}: expected one of {}", args.scene, names.join(", ")));
        return None;
    };
    let mut given = given.clone();
    settings::name_choices(&mut given, &scene.parameters);
    let complete = complete_parameters(&scene.parameters, &given);
    complete.map_err(|errors| errors.iter().for_each(|error| mistakes.add(format!("--set scene.{error}")))).ok()
}

/// The parameter that is a renderer's quality index, if it has one.
fn quality_parameter(renderer: &RendererInfo) -> Option<&ParameterSchema> {
    let DetailLaw::Line { quality_index: Some(name), .. } = &renderer.detail else { return None };
    renderer.parameters.iter().find(|schema| &schema.name == name)
}

/// Who takes part, the reference first.
fn entrants(args: &RenderersArgs, known: &Catalogue, given: &Parameters, mistakes: &mut Mistakes) -> Vec<Entrant> {
    let chosen = renderers(args, known, mistakes);
    let mut given = given.clone();
    chosen.iter().for_each(|renderer| settings::name_choices(&mut given, &renderer.parameters));
    for (name, value) in &given {
        let schemas: Vec<_> =
            chosen.iter().flat_map(|renderer| &renderer.parameters).filter(|schema| &schema.name == name).collect();
        mistakes.add_if(schemas.is_empty() && !chosen.is_empty(), || {
            format!("--set {name}: expected a parameter of the scene as scene.NAME, or of one of the renderers")
        });
        // Renderers whose parameters have a name in common may differ in its bounds; one that refuses is enough.
        if let Some(error) = schemas.iter().find_map(|schema| schema.check(value).err()) {
            mistakes.add(format!("--set {error}"));
        }
        mistakes.add_if(
            !args.quality.is_empty() && chosen.iter().any(|r| quality_parameter(r).is_some_and(|q| &q.name == name)),
            || format!("--set {name}: expected no value, since --quality sets it"),
        );
    }
    let qualities = qualities(args, &chosen, mistakes);
    let mut entrants = Vec::new();
    for renderer in &chosen {
        let own = |name: &String| renderer.parameters.iter().any(|schema| &schema.name == name);
        let parameters: Parameters =
            given.iter().filter(|(name, _)| own(name)).map(|(name, value)| (name.clone(), value.clone())).collect();
        let complete = |given: &Parameters| complete_parameters(&renderer.parameters, given).unwrap_or_default();
        let entrant = |quality_index, parameters| Entrant { renderer: renderer.id.clone(), quality_index, parameters };
        match quality_parameter(renderer).filter(|_| !qualities.is_empty()) {
            None => entrants.push(entrant(None, complete(&parameters))),
            Some(schema) => entrants.extend(qualities.iter().map(|&quality| {
                let mut parameters = parameters.clone();
                parameters.insert(schema.name.clone(), ParameterValue::Number(quality));
                entrant(Some(quality), complete(&parameters))
            })),
        }
    }
    entrants
}

/// The renderers that were asked for, each once, the reference first. Where none was asked for, all there are; where
/// qualities are, those that have one.
fn renderers<'a>(args: &RenderersArgs, known: &'a Catalogue, mistakes: &mut Mistakes) -> Vec<&'a RendererInfo> {
    for id in args.renderer.iter().filter(|id| known.renderer(id).is_none()) {
        let names: Vec<&str> = known.renderers.iter().map(|renderer| renderer.id.as_str()).collect();
        mistakes.add(format!("--renderer {id}: expected one of {}", names.join(", ")));
    }
    let wanted = |renderer: &&RendererInfo| match (args.renderer.as_slice(), args.quality.as_slice()) {
        ([], []) => true,
        ([], _) => quality_parameter(renderer).is_some(),
        (ids, _) => ids.contains(&renderer.id),
    };
    let others = known.renderers.iter().filter(|renderer| renderer.id != REFERENCE).filter(wanted);
    known.renderer(REFERENCE).into_iter().chain(others).collect()
}

/// The qualities, ascending, each once.
fn qualities(args: &RenderersArgs, chosen: &[&RendererInfo], mistakes: &mut Mistakes) -> Vec<f64> {
    if args.quality.is_empty() {
        return Vec::new();
    }
    let schemas: Vec<&ParameterSchema> = chosen.iter().filter_map(|renderer| quality_parameter(renderer)).collect();
    // A name that is unknown has been reported already.
    let all_known = args.renderer.iter().all(|id| chosen.iter().any(|renderer| &renderer.id == id));
    mistakes.add_if(schemas.is_empty() && all_known, || {
        format!("--quality: expected a renderer with a quality index, found {}", args.renderer.join(", "))
    });
    let mut qualities = Vec::new();
    for text in &args.quality {
        let number: Option<f64> = text.trim().parse().ok();
        // 0 says that there is no quality index.
        let accepted = number.filter(|&quality| {
            quality > 0.0 && schemas.iter().all(|schema| schema.check(&ParameterValue::Number(quality)).is_ok())
        });
        match accepted {
            Some(quality) => qualities.push(quality),
            None => {
                let bounds = schemas.first().map_or_else(|| "a number".to_owned(), |schema| schema.expectation());
                mistakes.add(format!("--quality {text}: expected {bounds}, above 0"));
            }
        }
    }
    qualities.sort_by(f64::total_cmp);
    qualities.dedup();
    qualities
}

/// Whether a file could be written there.
fn can_be_written(path: &Path) -> bool {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    folder.is_dir() && !path.is_dir()
}
