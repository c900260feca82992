//! Numbers as people read them, in the window and in reports.

/// A number with thin groups of three.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A number with three digits that count; very small and very large ones with a power of ten.
pub(crate) fn significant(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    // Rounded first, so that 9.996 counts as 10.0.
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    let power = rounded.abs().log10().floor() as i32;
    if (-4..6).contains(&power) {
        format!("{rounded:.*}", usize::try_from(2 - power).unwrap_or(0))
    } else {
        format!("{rounded:.2e}")
    }
}

/// A fraction of the diagonal, in percent.
pub(crate) fn percent(fraction: f64) -> String {
    format!("{}\u{202f}%", significant(fraction * 100.0))
}

/// A length in model units, with their name if it is known.
pub(crate) fn length(x: f64, unit: &str) -> String {
    let number = significant(x);
    if unit.is_empty() { number } else { format!("{number}\u{202f}{unit}") }
}

/// How many of something, in words.
pub(crate) fn counted(number: u32, one: &str, many: &str) -> String {
    format!("{} {}", grouped(u64::from(number)), if number == 1 { one } else { many })
}

/// How a measured distance stands to the tolerance demanded.
pub(crate) fn tolerance(max: f64, demanded: f64) -> String {
    if max <= demanded {
        format!("met: {} at most, {} allowed", percent(max), percent(demanded))
    } else {
        let factor = significant(max / demanded);
        format!("not met: {} at most, {factor} times the {} allowed", percent(max), percent(demanded))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_that_count() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.00"),
            (0.012345, "0.0123"),
            (9.996, "10.0"),
            (123.4, "123"),
            (98_765.0, "98800"),
            (1.234e-7, "1.23e-7"),
            (4.5e9, "4.50e9"),
            (-0.5, "-0.500"),
        ] {
            assert_eq!(significant(x), text);
        }
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(length(2.5, "mm"), "2.50\u{202f}mm");
        assert_eq!(counted(1, "loop", "loops"), "1 loop");
    }

    #[test]
    fn a_tolerance_is_met_or_missed_by_a_factor() {
        assert!(tolerance(1e-3, 1e-3).starts_with("met"));
        let missed = tolerance(3e-3, 1e-3);
        assert!(missed.starts_with("not met") && missed.contains("3.00 times"), "{missed}");
    }
}
