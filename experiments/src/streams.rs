//! Named random streams: one seed for a session, one independent stream for each purpose.
//!
//! A session's seed and a stream's name fix every number drawn from it, whatever the other streams do, so that for
//! example a different observer meets the same design.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The generator behind every stream, as written to session headers.
pub const GENERATOR: &str = "ChaCha8 (rand_chacha 0.10), stream = FNV-1a of the name";

/// What a stream is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Order of trials and of intervals.
    Design,
    /// Choices of an adaptive procedure.
    Procedure,
    /// What a simulated observer answers.
    Observer,
    /// A simulated eye and tracker.
    Gaze,
    /// Sample positions of a renderer.
    Sampling,
}

impl Stream {
    /// The name that is hashed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Procedure => "procedure",
            Self::Observer => "observer",
            Self::Gaze => "gaze",
            Self::Sampling => "sampling",
        }
    }

    /// The stream's generator for a session seed.
    #[must_use]
    pub fn generator(self, seed: u64) -> ChaCha8Rng {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(fnv1a(self.name().as_bytes()));
        generator
    }
}

/// FNV-1a, 64 bits: a fixed, documented hash, so that streams do not change with the standard library's.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn streams_repeat_and_differ() {
        let draw = |stream: Stream, seed| stream.generator(seed).next_u64();
        assert_eq!(draw(Stream::Design, 7), draw(Stream::Design, 7));
        assert_ne!(draw(Stream::Design, 7), draw(Stream::Observer, 7));
        assert_ne!(draw(Stream::Design, 7), draw(Stream::Design, 8));
    }

    /// The published FNV-1a test vector for "a".
    #[test]
    fn the_hash_is_fnv1a() {
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
    }
}
