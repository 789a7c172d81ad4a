//! The panoramas that ship with this crate; their licences are in `assets/LICENSES.md`.

use super::Panorama;
use crate::contract::MakeError;

/// One of the shipped panoramas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Sky {
    /// A park under a high sun.
    #[default]
    Park,
    /// A valley before sunrise.
    Dawn,
    /// A canal in Venice under a low sun.
    Venice,
    /// A workshop with windows.
    Workshop,
}

impl Sky {
    /// All of them, in the order in which they are listed to users.
    pub(crate) const ALL: [Self; 4] = [Self::Park, Self::Dawn, Self::Venice, Self::Workshop];

    /// Its name in studies.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Park => "park",
            Self::Dawn => "dawn",
            Self::Venice => "venice",
            Self::Workshop => "workshop",
        }
    }

    /// The panorama called `name`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|sky| sky.name() == name)
    }

    /// Its radiance, with a mean of `mean`.
    ///
    /// # Errors
    /// When it does not decode, which would be a damaged program.
    pub(crate) fn panorama(self, mean: f32) -> Result<Panorama, MakeError> {
        let bytes: &[u8] = match self {
            Self::Park => include_bytes!("../../assets/environments/park.exr"),
            Self::Dawn => include_bytes!("../../assets/environments/dawn.exr"),
            Self::Venice => include_bytes!("../../assets/environments/venice.exr"),
            Self::Workshop => include_bytes!("../../assets/environments/workshop.exr"),
        };
        Panorama::shipped(self.name(), bytes, mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Environment;

    /// Every shipped panorama decodes to 512×256 finite values with the asked-for mean, and lights from above.
    #[test]
    fn every_sky_decodes_and_lights() {
        for sky in Sky::ALL {
            assert_eq!(Sky::named(sky.name()), Some(sky));
            let panorama = sky.panorama(0.6).unwrap();
            assert_eq!(panorama.size, [512, 256]);
            let sum: f64 = panorama.radiance.iter().map(|c| f64::from(c.element_sum())).sum();
            let mean = sum / (3 * panorama.radiance.len()) as f64;
            let most = panorama.radiance.iter().map(|c| c.max_element()).fold(0.0, f32::max);
            let environment = Environment::of(panorama);
            println!("{}: mean {mean:.4}, brightest {most:.1}, sun {:?}", sky.name(), environment.sun);
            assert!((mean - 0.6).abs() < 1e-3 && most.is_finite());
            assert!(environment.ambient.iter().all(|c| c.is_finite()) && environment.ambient[0].min_element() > 0.0);
        }
    }
}
