//! What is wrong with a renderer's text is said at the text's own line and column, whatever it is.

use super::*;
use experiments::catalogue::{DetailLaw, ParameterKind};

const GOOD: &str = "\
//! Colour that fades
//! away from the gaze.
//! source: ours
//! version: 3
//! parameter radius_deg [°] 0..60 = 8: Where it begins.
//! parameter strength [] -1e2..1 = 0.5: How much.
//! detail: full

fn colour(at: Place, given: Parameters) -> vec3f {
    let sharp = picture_at(at.px);
    let grey = dot(sharp, vec3f(0.2126, 0.7152, 0.0722));
    let far = smoothstep(given.radius_deg, given.radius_deg + 5.0, at.eccentricity_deg);
    return mix(sharp, vec3f(grey), far * given.strength);
}
";

fn mistakes(text: &str) -> Vec<(usize, usize, String)> {
    let found = WgslProgram::compile("mine", text, "mine.wgsl").expect_err("a mistake");
    assert_eq!(found.file, "mine.wgsl");
    found.list.into_iter().map(|m| (m.line, m.column, m.message)).collect()
}

#[test]
fn the_head_is_what_studies_see() {
    let info = WgslProgram::compile("mine", GOOD, "mine.wgsl").expect("no mistake").info().clone();
    assert_eq!((info.id.as_str(), info.version, info.source.as_str()), ("mine", 3, "ours"));
    assert_eq!(info.about, "Colour that fades away from the gaze.");
    assert_eq!(info.detail, DetailLaw::Full);
    assert_eq!(info.parameters.len(), 2);
    let expected = ParameterKind::Number { unit: "°".to_owned(), min: 0.0, max: 60.0, default: 8.0 };
    assert_eq!((info.parameters[0].name.as_str(), &info.parameters[0].kind), ("radius_deg", &expected));
    // No head at all is allowed, and so is a function that uses nothing.
    let bare =
        WgslProgram::compile("bare", "fn colour(at: Place, given: Parameters) -> vec3f { return vec3f(0.5); }", "b");
    assert!(bare.expect("no mistake").info().parameters.is_empty());
}

/// Each edit makes one mistake, at this line and column, with these words.
#[test]
fn each_mistake_is_at_its_own_line() {
    let edits = [
        // The head.
        ("//! version: 3", "//! version: 0", 4, 14, "whole number from 1"),
        ("0..60 = 8", "60..0 = 8", 5, 30, "smaller to its larger end, found 60..0"),
        ("0..60 = 8", "0..60 = 61", 5, 38, "default from 0 to 60"),
        ("0..60 = 8", "0..60 = NaN", 5, 38, "expected a number, found \"NaN\""),
        ("0..60 = 8", "0..inf = 8", 5, 33, "expected a number"),
        ("0..60 = 8", "0..60", 5, 15, "//! parameter NAME"),
        ("0..60 = 8: Where it begins.", "0..60 = 8:", 5, 15, "a sentence"),
        ("parameter strength", "parameter radius_deg", 6, 15, "once"),
        ("parameter strength", "parameter Strength", 6, 15, "letters a-z"),
        ("parameter strength", "parameter while", 6, 15, "a word it keeps"),
        ("parameter strength", "param strength", 6, 5, "//! parameter NAME"),
        ("detail: full", "detail: line radius_deg mar", 7, 13, "\"mar\""),
        ("detail: full", "detail: sharp", 7, 13, "gaussian RADIUS RATE"),
        // The code.
        ("picture_at(at.px)", "picture_at(at.pixel)", 10, 31, "pixel"),
        ("let grey = dot(sharp,", "let grey = dto(sharp,", 11, 16, "dto"),
        ("far * given.strength);", "far * given.strenth);", 13, 48, "strenth"),
        ("return mix(sharp, vec3f(grey), far * given.strength);", "return grey;", 11, 16, "return"),
        ("fn colour(at", "fn color(at", 1, 1, "found none called colour"),
        ("fn colour(at: Place, given: Parameters)", "fn colour(at: Place)", 12, 26, "given"),
        ("-> vec3f {\n    let sharp", "-> vec4f {\n    let sharp", 9, 4, "found another declaration"),
    ];
    for (old, new, line, column, words) in edits {
        assert_eq!(GOOD.matches(old).count(), 1, "{old}");
        let found = mistakes(&GOOD.replace(old, new));
        println!("{new}: {found:?}");
        assert_eq!(found.len(), 1, "{new}: {found:?}");
        assert!(found[0].2.contains(words), "{words:?} is not in {found:?}");
        assert_eq!((found[0].0, found[0].1), (line, column), "{found:?}");
    }
}

/// What only the frame around the function finds is said where the function stands.
#[test]
fn another_declaration_is_named() {
    for (text, line, column, words) in [
        ("\nfn colour(at: Place) -> vec3f { return vec3f(1.0); }", 2, 4, "found another declaration"),
        ("fn colour(at: Place, given: vec3f) -> vec3f { return given; }", 1, 4, "found another declaration"),
        ("fn colour(at: Place, given: Parameters) -> f32 { return 1.0; }", 1, 4, "found another declaration"),
        ("fn colour(at: Place, given: Parameters) -> vec3f { return vec3f(1.0); }\n/* no end", 2, 1, "unterminated"),
    ] {
        let found = mistakes(text);
        println!("{text}: {found:?}");
        assert!(found[0].2.contains(words), "{words:?} is not in {found:?}");
        assert_eq!((found[0].0, found[0].1), (line, column), "{found:?}");
    }
}

#[test]
fn names_of_the_frame_and_bindings_are_refused_where_they_stand() {
    let added = [
        ("fn mirrored(a: i32) -> i32 { return a; }\n", "\"mirrored\""),
        ("struct Place { x: f32 }\n", "\"Place\""),
        ("fn sample_level(a: f32) -> f32 { return a; }\n", "sample_level"),
        ("@group(1) @binding(0) var<uniform> more: vec4f;\n", "no bindings"),
        ("@group(0) @binding(7) var more: texture_2d<f32>;\n", "no bindings"),
        ("override strength: f32 = 1.0;\n", "an override"),
        ("fn parafovea_mine() -> f32 { return 1.0; }\n", "parafovea_"),
    ];
    for (line, words) in added {
        let found = mistakes(&format!("{GOOD}{line}"));
        println!("{line}: {found:?}");
        assert_eq!((found.len(), found[0].0), (1, 15), "{line}: {found:?}");
        assert!(found[0].2.contains(words), "{words:?} is not in {found:?}");
    }
    let late = mistakes(&format!("{GOOD}//! parameter late [] 0..1 = 0: Too late.\n"));
    assert_eq!((late.len(), late[0].0), (1, 15), "{late:?}");
}

/// Cut off anywhere, a text is refused at one of its own lines or is a whole renderer, and nothing panics.
#[test]
fn a_torn_text_never_panics() {
    for end in (0..GOOD.len()).filter(|&end| GOOD.is_char_boundary(end)) {
        let torn = &GOOD[..end];
        if let Err(found) = WgslProgram::compile("mine", torn, "mine.wgsl") {
            let lines = 1 + torn.matches('\n').count();
            assert!(found.list.iter().all(|m| (1..=lines).contains(&m.line)), "{end}: {found}");
        }
    }
    for hostile in
        ["", "\0", "//!", "//! parameter", "//! parameter [", "//! parameter a [ ] .. = :", "ﬀ{", "/*", "//! détail: é"]
    {
        assert!(!mistakes(hostile).is_empty(), "{hostile:?}");
    }
    let huge = "x".repeat(LONGEST_TEXT + 1);
    assert!(mistakes(&huge)[0].2.contains("at most"));
    // Nested deeper than a parser's stack.
    let deep = format!(
        "fn colour(at: Place, given: Parameters) -> vec3f {{ return vec3f({}1.0{}); }}",
        "(".repeat(5000),
        ")".repeat(5000)
    );
    assert!(!mistakes(&deep).is_empty());
}
