//! The studies that come with the program, compiled in so that they are there without any file.

/// A study that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShippedStudy {
    /// Its name, as in the file.
    pub name: &'static str,
    /// One sentence for a list of studies.
    pub about: &'static str,
    /// The file's text.
    pub json: &'static str,
}

/// Every study that comes with the program.
#[must_use]
pub fn shipped() -> &'static [ShippedStudy] {
    const SHIPPED: [ShippedStudy; 2] = [
        ShippedStudy {
            name: "mar-calibration",
            about: "How fast acuity falls with eccentricity: omega0 and m of one observer, on a 27\" laboratory display.",
            json: include_str!("../../studies/mar-calibration.json"),
        },
        ShippedStudy {
            name: "mar-demo",
            about: "The same question on a small display that a computer without a GPU can draw; what `demo` runs.",
            json: include_str!("../../studies/mar-demo.json"),
        },
    ];
    &SHIPPED
}
