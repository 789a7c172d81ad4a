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
    const SHIPPED: [ShippedStudy; 9] = [
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
        ShippedStudy {
            name: "guenter-pair",
            about: "Guenter 2012: pairs of sequences, reference and eccentricity layers; which is better, or the same?",
            json: include_str!("../../studies/guenter-pair.json"),
        },
        ShippedStudy {
            name: "guenter-ramp",
            about: "Guenter 2012: quality that rises or falls in steps; which way did it go?",
            json: include_str!("../../studies/guenter-ramp.json"),
        },
        ShippedStudy {
            name: "guenter-slider",
            about: "Guenter 2012: observers raise the quality until it looks like the reference.",
            json: include_str!("../../studies/guenter-slider.json"),
        },
        ShippedStudy {
            name: "tursun-calibration",
            about: "Tursun 2019: blur beyond a radius in 36 textures, toggled 2AFC, six sittings.",
            json: include_str!("../../studies/tursun-calibration.json"),
        },
        ShippedStudy {
            name: "weier-likert",
            about: "Weier 2016: scenes × foveal regions × fixation types, rated on 7-point scales.",
            json: include_str!("../../studies/weier-likert.json"),
        },
        ShippedStudy {
            name: "stengel-calibration",
            about: "Stengel 2016: observers adjust the foveation until they see no difference.",
            json: include_str!("../../studies/stengel-calibration.json"),
        },
        ShippedStudy {
            name: "stengel-validation",
            about: "Stengel 2016: which of two sequences was better, while counting, following or looking around?",
            json: include_str!("../../studies/stengel-validation.json"),
        },
    ];
    &SHIPPED
}
