//! Roots of monotone functions, by Newton's steps inside a bracket that only ever shrinks.

/// The root of an increasing `f` in `low..high`, from `start`; `f` gives value and slope.
///
/// A step that leaves the bracket, or that is no number, becomes a bisection. The answer is within a few units of the
/// last digit where the function allows it.
pub(super) fn increasing_root(mut low: f64, mut high: f64, start: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut x = if start > low && start < high { start } else { 0.5 * (low + high) };
    let width = high - low;
    for _ in 0..200 {
        let (value, slope) = f(x);
        if value == 0.0 {
            return x;
        }
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        // Newton's steps shrink quadratically: after one of 1e-10, the next would be below the last digit. Waiting for
        // that would only follow the rounding of `f`.
        let close = if inside { 1e-10 * x.abs() + 1e-13 * width } else { 1e-15 * x.abs() };
        if (next - x).abs() <= close {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steep_flat_and_broken_slopes_all_find_the_root() {
        let cube = |x: f64| (x * x * x - 2.0, 3.0 * x * x);
        assert!((increasing_root(-10.0, 10.0, 0.0, cube) - 2f64.cbrt()).abs() < 1e-15);
        // A slope of zero or of no number leaves bisection.
        let unknown = |x: f64| (x - 0.3, f64::NAN);
        assert!((increasing_root(0.0, 1.0, 0.9, unknown) - 0.3).abs() < 1e-14);
        let saturated = |x: f64| (x.tanh() - 0.5, 1.0 - x.tanh().powi(2));
        assert!((increasing_root(-900.0, 900.0, 100.0, saturated) - 0.5f64.atanh()).abs() < 1e-14);
    }
}
