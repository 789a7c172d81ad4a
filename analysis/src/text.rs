//! Numbers as text, and small pieces of HTML.

use crate::mar::Estimate;
use crate::svg::escape;

/// A number with `digits` significant digits, a true minus sign and no exponent between 1e-6 and 1e9.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    let text = if (-6..9).contains(&magnitude) {
        let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
        // Rounding may carry into the next decade; trailing zeros are kept, since they say how precise a number is.
        let text = format!("{value:.decimals$}");
        if decimals == 0 || value.fract() != 0.0 { text } else { format!("{value}") }
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    };
    text.replace('-', "−")
}

/// A share as a percentage with one decimal.
pub(crate) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.1} %", 100.0 * share) } else { "–".to_owned() }
}

/// Seconds as milliseconds with one decimal.
pub(crate) fn milliseconds(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "–".to_owned(), |s| format!("{:.1} ms", 1000.0 * s))
}

/// Degrees with two decimals.
pub(crate) fn degrees(angle: Option<f64>) -> String {
    angle.map_or_else(|| "–".to_owned(), |a| format!("{a:.2}°"))
}

/// `low – high` of an interval.
pub(crate) fn interval(ci95: [f64; 2]) -> String {
    format!("{} – {}", significant(ci95[0], 3), significant(ci95[1], 3))
}

/// `estimate (95 % CI low – high)`.
pub(crate) fn with_interval(estimate: &Estimate) -> String {
    format!("{} (95 % CI {})", significant(estimate.estimate, 3), interval(estimate.ci95))
}

/// A list of labelled facts.
pub(crate) fn facts(rows: &[(String, String)]) -> String {
    let mut html = String::from("<dl>\n");
    for (label, value) in rows {
        let wide = if value.chars().count() > 60 { " class=\"wide\"" } else { "" };
        html.push_str(&format!("<div{wide}><dt>{}</dt><dd>{}</dd></div>\n", escape(label), escape(value)));
    }
    html.push_str("</dl>\n");
    html
}

/// A figure with its caption; `svg` is trusted, `caption` is not.
pub(crate) fn figure(svg: &str, caption: &str) -> String {
    format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escape(caption))
}

/// Items of a sentence: `a, b and c`.
pub(crate) fn listed(items: &[String]) -> String {
    match items {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        assert_eq!(significant(0.020833, 3), "0.0208");
        assert_eq!(significant(0.0220, 3), "0.0220");
        assert_eq!(significant(5.0, 3), "5");
        assert_eq!(significant(123.456, 3), "123");
        assert_eq!(significant(-0.5, 2), "−0.50");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(2.5e-9, 3), "2.50e−9");
    }
}
