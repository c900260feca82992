//! Log lines: each reads back as it was written, to the bit of every number, and a damaged one is refused.

use bozzetto_core::edit::{Edit, Entry, Falloff, Gain, Kind, Line, LineError, Move};
use bozzetto_core::surface::SurfaceHash;
use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
use proptest::prelude::*;

fn finite() -> impl Strategy<Value = f64> {
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO
}

fn entry() -> impl Strategy<Value = Entry> {
    let kind = prop_oneof![Just(Kind::Scaling), Just(Kind::Wavelet)];
    let falloffs = [Falloff::Smooth, Falloff::Linear, Falloff::Sharp, Falloff::Constant];
    let place = (kind, any::<u8>(), any::<u32>(), 0..4u32);
    let reach = (prop::option::of(finite()), prop::option::of(prop::sample::select(falloffs.to_vec())));
    let moved = (place, prop::array::uniform3(finite()), reach).prop_map(
        |((kind, level, vertex, v), delta, (radius, falloff))| {
            Entry::Edit(Edit::Move(Move { kind, level, vertex, delta, radius, falloff, mirror: None, v }))
        },
    );
    let gain = (any::<u8>(), finite(), 0..4u32)
        .prop_map(|(level, factor, v)| Entry::Edit(Edit::Gain(Gain { level, factor, v })));
    prop_oneof![
        8 => moved,
        2 => gain,
        1 => (1..=u32::MAX).prop_map(Entry::Undo),
        1 => (1..=u32::MAX).prop_map(Entry::Redo),
        1 => Just(Entry::Save),
        1 => Just(Entry::Discard),
        1 => ".*".prop_map(|of| Entry::Binding { of }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn lines_read_back_as_written(entry in entry(), hash in prop::option::of(any::<[u8; 16]>())) {
        let hash = hash.map(SurfaceHash);
        let text = Line::to_text(&entry, hash);
        prop_assert!(!text.contains('\n'), "{}", text);
        let line = Line::parse(&text).map_err(|e| TestCaseError::fail(format!("{text}: {e}")))?;
        prop_assert_eq!(&line, &Line { entry, hash, checked: true }, "{}", text);
        // Zeros keep their sign, too.
        prop_assert_eq!(Line::to_text(&line.entry, line.hash), text);
    }

    /// Any damage to a line with a checksum is noticed.
    #[test]
    fn damaged_lines_are_refused(entry in entry(), at in 0.0..1.0f64, to: char) {
        let text = Line::to_text(&entry, None);
        let mut letters: Vec<char> = text.chars().collect();
        let at = (at * letters.len() as f64) as usize;
        prop_assume!(letters[at] != to);
        letters[at] = to;
        let damaged: String = letters.iter().collect();
        match Line::parse(&damaged) {
            Err(_) => {}
            // Without its name a checksum is no checksum; a journal takes no line without.
            Ok(line) => prop_assert!(!line.checked, "{}", damaged),
        }
    }
}

#[test]
fn bad_lines_say_what_is_wrong() {
    let of = |text: &str| Line::parse(text).expect_err(text);
    assert!(matches!(of("{"), LineError::NotJson(_)));
    assert!(matches!(of("[1]"), LineError::NotJson(_)));
    assert_eq!(of("{}"), LineError::Unknown);
    assert_eq!(of("{\"undone\":1}"), LineError::Unknown);
    assert_eq!(of("{\"undo\":1,\"crc\":\"00000000\"}"), LineError::Checksum);
    assert_eq!(of("{\"crc\":\"00000000\",\"undo\":1}"), LineError::Checksum);
    let sealed = Line::to_text(&Entry::Undo(1), None);
    assert_eq!(of(&sealed.replace("\"}", "\",\"redo\":1}")), LineError::Checksum, "after the checksum");
    for fields in [
        "{\"undo\":0}",
        "{\"undo\":1.5}",
        "{\"undo\":-1}",
        "{\"undo\":4294967296}",
        "{\"undo\":1,\"redo\":1}",
        "{\"save\":1,\"of\":\"x\"}",
        "{\"log\":1}",
        "{\"log\":2,\"of\":\"x\"}",
        "{\"edit\":\"melt\",\"level\":1}",
        "{\"edit\":\"gain\",\"level\":1}",
        "{\"edit\":\"gain\",\"level\":1,\"factor\":1,\"colour\":3}",
        "{\"edit\":\"gain\",\"level\":300,\"factor\":1}",
        "{\"edit\":\"gain\",\"level\":1,\"factor\":\"much\"}",
        "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"delta\":[0,0]}",
        "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"delta\":[0,0,null]}",
        "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"delta\":[0,0,1e999]}",
        "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"delta\":[0,0,0],\"fallof\":\"sharp\"}",
        "{\"undo\":1,\"hash\":\"12\"}",
        "{\"undo\":1,\"hash\":12}",
    ] {
        assert!(
            matches!(of(fields), LineError::Fields(_) | LineError::NotJson(_)),
            "{fields}: {:?}",
            of(fields)
        );
    }
}
