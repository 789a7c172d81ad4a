//! A description as text for a terminal, in lines of at most 100 columns.

use super::{ANSWER_S, BlockDescription, Description, DisplayDescription, Effort, FactorDescription, ParameterRange};
use std::fmt;

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.trials_min == self.trials_max {
            write!(f, "{} trials, about {:.1} min", self.trials_max, self.minutes_max)
        } else {
            write!(
                f,
                "{}–{} trials, about {:.1}–{:.1} min",
                self.trials_min, self.trials_max, self.minutes_min, self.minutes_max
            )
        }
    }
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} – {}", self.study, self.title)?;
        wrapped(f, "  ", &self.about)?;
        writeln!(f, "\n{}", self.display)?;
        let [x, y] = self.fixation_deg;
        write!(f, "Gaze      fixation at ({x}°, {y}°)")?;
        match (self.gate_deg, self.gate_grace_s) {
            (Some(radius), Some(grace)) => writeln!(f, ", gate of {radius}° with {grace} s of grace")?,
            _ => writeln!(f, ", no gate")?,
        }
        let mut first = Vec::new();
        if self.consent {
            first.push("consent".to_owned());
        }
        if !self.participant.is_empty() {
            first.push(format!("a form ({})", self.participant.join(", ")));
        }
        if !first.is_empty() {
            wrapped(f, "First     ", &first.join(", then "))?;
        }
        for file in &self.files {
            wrapped(f, "File      ", &format!("{}: {} from {}", file.name, file.source.what(), file.source.path()))?;
        }
        for (index, block) in self.blocks.iter().enumerate() {
            writeln!(
                f,
                "\nBlock {}   {}{}",
                index + 1,
                block.name,
                if block.practice && block.name != "practice" { " (practice)" } else { "" }
            )?;
            write!(f, "{block}")?;
        }
        let blocks = if self.blocks.len() == 1 { "block" } else { "blocks" };
        writeln!(f, "\nIn all    {} {blocks}, {}", self.blocks.len(), self.total)?;
        for group in &self.groups {
            writeln!(f, "Group     {}: {} – {}", group.name, group.blocks.join(", "), group.effort)?;
        }
        if let Some(one) = self.sittings.first() {
            let same = self.sittings.iter().all(|other| other == one);
            let each = if same { one.to_string() } else { format!("the first with {one}") };
            writeln!(f, "Sittings  {} of each observer, {each}", self.sittings.len())?;
        }
        write!(f, "          (an answer is taken to need {ANSWER_S} s; pages, breaks and aborted trials come on top)")
    }
}

impl fmt::Display for DisplayDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([w, h], [w_mm, h_mm], [w_deg, h_deg]) = (self.resolution_px, self.size_mm, self.size_deg);
        writeln!(
            f,
            "Display   {}: {w} × {h} px, {w_mm:.0} × {h_mm:.0} mm from {:.0} mm, {} Hz",
            self.name, self.distance_mm, self.refresh_hz
        )?;
        write!(
            f,
            "          {w_deg:.1}° × {h_deg:.1}°, {:.1} px per degree, finest MAR {:.4}° per cycle at the centre",
            self.px_per_deg, self.finest_mar_deg
        )
    }
}

impl fmt::Display for BlockDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        wrapped(f, "  shows   ", &format!("{}: {} under {}", self.condition, self.scene, self.renderer))?;
        if !self.factors.is_empty() {
            let crossed: Vec<String> = self.factors.iter().map(factor_in_words).collect();
            wrapped(f, "  varies  ", &format!("{}: {} cells", crossed.join(" × "), self.cells))?;
        }
        wrapped(f, "  looking ", &self.looks)?;
        wrapped(f, "  asks    ", &self.protocol)?;
        wrapped(f, "  by      ", &self.procedure)?;
        write!(f, "  trials  {}", self.effort)?;
        if let Some(every) = self.break_every_trials {
            write!(f, ", a break every {every} trials")?;
        }
        if let Some(every) = self.break_every_minutes {
            write!(f, ", a break every {every} min")?;
        }
        writeln!(f)?;
        let order: Vec<&str> =
            [self.presentation.as_str(), self.order.as_str()].into_iter().filter(|w| !w.is_empty()).collect();
        wrapped(f, "  order   ", &order.join("; "))?;
        wrapped(f, "  ends    ", &self.stop)?;
        match self.continuous {
            true => write!(f, "  levels  any between two limits")?,
            false => write!(f, "  levels  {}", self.levels)?,
        }
        match self.mar_deg {
            Some([fine, coarse]) if fine < coarse => write!(f, ", MAR {fine:.4}–{coarse:.4}° per cycle")?,
            Some([only, _]) => write!(f, ", MAR {only:.4}° per cycle")?,
            None => {}
        }
        if self.mar_deg.is_none() {
            for range in &self.parameters {
                let ParameterRange { name, values, min, max } = range;
                match values {
                    1 => write!(f, ", {name} {min}")?,
                    2 if self.continuous => write!(f, ", {name} {min}–{max}")?,
                    _ => write!(f, ", {name} {min}–{max} ({values} values)")?,
                }
            }
        }
        if self.levels_beyond_display > 0 {
            write!(f, "; {} finer than the display can show are left out", self.levels_beyond_display)?;
        }
        writeln!(f)?;
        if !self.eccentricities.is_empty() {
            writeln!(f, "          eccentricity   ring on display   finest MAR   levels")?;
        }
        for row in &self.eccentricities {
            writeln!(
                f,
                "          {:>11.1}° {:>15.0} % {:>11.4}° {:>8}",
                row.eccentricity_deg,
                100.0 * row.visible_share,
                row.finest_mar_deg,
                row.levels
            )?;
        }
        if let Some(criterion) = &self.criterion {
            wrapped(f, "  passed  ", criterion)?;
        }
        if !self.questionnaire.is_empty() {
            wrapped(f, "  then    ", &format!("a questionnaire ({})", self.questionnaire.join(", ")))?;
        }
        Ok(())
    }
}

/// A factor with its levels; of many only how many.
fn factor_in_words(factor: &FactorDescription) -> String {
    let FactorDescription { name, levels } = factor;
    match levels.len() {
        0..=8 => format!("{name} ({})", levels.join(", ")),
        n => format!("{name} ({n} levels)"),
    }
}

/// Writes words in lines of at most 98 columns, the first after `label`, the others as far in.
fn wrapped(f: &mut fmt::Formatter<'_>, label: &str, text: &str) -> fmt::Result {
    const COLUMNS: usize = 98;
    let indent = label.chars().count();
    let mut line = label.to_owned();
    let mut column = indent;
    for word in text.split_whitespace() {
        let width = word.chars().count();
        if column > indent && column + 1 + width > COLUMNS {
            writeln!(f, "{}", line.trim_end())?;
            line = " ".repeat(indent);
            column = indent;
        }
        if column > indent {
            line.push(' ');
            column += 1;
        }
        line.push_str(word);
        column += width;
    }
    if column > indent {
        writeln!(f, "{line}")?;
    }
    Ok(())
}
