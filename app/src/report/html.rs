//! Text in HTML.

use std::fmt::{Display, Formatter, Result, Write};

/// Text as it stands in HTML, inside elements and quoted attributes. Control characters, and those that turn the
/// direction of writing round, become a replacement character.
pub(super) struct Text<'a>(pub(super) &'a str);

impl Display for Text<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                    f.write_char(char::REPLACEMENT_CHARACTER)?;
                }
                c if c.is_control() => f.write_char(char::REPLACEMENT_CHARACTER)?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// A table of names and values; both are escaped.
pub(super) fn pairs<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let mut html = String::from("<table class=\"pairs\">\n");
    for (name, value) in rows {
        let (name, value) = (Text(name), Text(&value));
        html += &format!("<tr><th scope=\"row\">{name}</th><td>{value}</td></tr>\n");
    }
    html + "</table>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_hostile_passes() {
        let name = "<script>alert(\"a\" + 'b')</script>&amp;\u{202e}lmth.\u{0}x\n";
        let shown = Text(name).to_string();
        assert!(!shown.contains(['<', '>', '"', '\'', '\u{202e}', '\u{0}', '\n']), "{shown}");
        assert!(
            shown.starts_with("&lt;script&gt;alert(&quot;a&quot; + &#39;b&#39;)&lt;/script&gt;&amp;amp;")
        );
        assert_eq!(Text("Kopf – scan 3.obj").to_string(), "Kopf – scan 3.obj");
    }
}
