//! Any bytes are a journal up to their first damage, and what was read can be folded into a record. A journal with its
//! seals made right, which random bytes never have, is read as far as its events make sense.
#![no_main]

use experiments::session::Stamped;
use experiments::session::record::Record;
use libfuzzer_sys::fuzz_target;
use parafovea::session::header::Header;
use parafovea::session::journal::{Chain, line_from_event, read};

fuzz_target!(|bytes: &[u8]| {
    for format in [1, 2] {
        let journal = read(bytes, format);
        assert!(journal.sound_bytes <= bytes.len());
        assert!(journal.damage.is_some() || journal.sound_bytes == bytes.len());
        let _ = Record::from_events(&journal.events);
    }
    let _ = Header::from_text(bytes);
    // Lines of JSON without seals: sealed here, they must come back.
    let mut chain = Chain::start(2);
    let mut events = Vec::new();
    let mut text = String::new();
    for line in bytes.split(|&byte| byte == b'\n') {
        let Ok(mut event) = serde_json::from_slice::<Stamped>(line) else { continue };
        if !event.t_s.is_finite() {
            continue;
        }
        event.seq = events.len() as u64;
        text += &line_from_event(&event, &mut chain);
        events.push(event);
    }
    let journal = read(text.as_bytes(), 2);
    assert_eq!(journal.damage, None);
    assert_eq!(journal.events.len(), events.len());
    let _ = Record::from_events(&journal.events);
});
