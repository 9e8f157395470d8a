//! Nesting depth of a text in RON or JSON, checked before it is parsed: parsers recurse, and a file
//! of 200,000 opening brackets would overflow the stack.

use crate::error::InputError;

/// Maximum depth of nested brackets; scenes have at most 12.
const MAX_DEPTH: usize = 64;

/// Check that brackets outside of strings and comments are nested at most [`MAX_DEPTH`] deep.
///
/// # Errors
/// At the line of the first bracket that is too deep.
pub(crate) fn check(text: &str) -> Result<(), InputError> {
    let bytes = text.as_bytes();
    let (mut at, mut depth, mut line) = (0, 0_usize, 1);
    while let Some(byte) = bytes.get(at) {
        let next = match byte {
            b'"' => string_end(bytes, at + 1),
            b'r' if raw_hashes(bytes, at).is_some() => raw_string_end(bytes, at),
            b'\'' => char_end(bytes, at),
            b'/' if bytes.get(at + 1) == Some(&b'/') => line_end(bytes, at),
            b'/' if bytes.get(at + 1) == Some(&b'*') => comment_end(bytes, at),
            b'(' | b'[' | b'{' => {
                depth += 1;
                if depth > MAX_DEPTH {
                    let problem = format!("brackets are nested more than {MAX_DEPTH} deep");
                    return Err(InputError::new("", problem).at_line(line));
                }
                at + 1
            }
            b')' | b']' | b'}' => {
                depth = depth.saturating_sub(1);
                at + 1
            }
            _ => at + 1,
        };
        line += bytes[at..next.min(bytes.len())].iter().filter(|b| **b == b'\n').count();
        at = next;
    }
    Ok(())
}

/// End of a string whose content begins at `at`.
fn string_end(bytes: &[u8], mut at: usize) -> usize {
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 2,
            b'"' => return at + 1,
            _ => at += 1,
        }
    }
    at
}

/// Number of `#` of a raw string that begins at `at`; `None` where none begins.
fn raw_hashes(bytes: &[u8], at: usize) -> Option<usize> {
    let hashes = bytes[at + 1..].iter().take_while(|b| **b == b'#').count();
    (bytes.get(at + 1 + hashes) == Some(&b'"')).then_some(hashes)
}

fn raw_string_end(bytes: &[u8], at: usize) -> usize {
    let hashes = raw_hashes(bytes, at).unwrap_or(0);
    let content = at + 2 + hashes;
    let closes = |i: &usize| bytes[*i] == b'"' && bytes[i + 1..].iter().take_while(|b| **b == b'#').count() >= hashes;
    (content..bytes.len()).find(closes).map_or(bytes.len(), |i| i + 1 + hashes)
}

/// End of a character literal, or the next byte where none begins at `at`.
fn char_end(bytes: &[u8], at: usize) -> usize {
    match (bytes.get(at + 1), bytes.get(at + 2), bytes.get(at + 3)) {
        (Some(b'\\'), Some(_), Some(b'\'')) => at + 4,
        (Some(_), Some(b'\''), _) => at + 3,
        _ => at + 1,
    }
}

fn line_end(bytes: &[u8], at: usize) -> usize {
    bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i)
}

/// End of a block comment, which may contain others.
fn comment_end(bytes: &[u8], mut at: usize) -> usize {
    let mut open = 0_usize;
    while at < bytes.len() {
        if bytes[at..].starts_with(b"/*") {
            (open, at) = (open + 1, at + 2);
        } else if bytes[at..].starts_with(b"*/") {
            (open, at) = (open - 1, at + 2);
            if open == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn deep_nesting_is_refused_with_its_line() {
        for text in ["(".repeat(200_000), format!("(\ndescription: {}", "[".repeat(100_000))] {
            let error = Scene::parse(&text).expect_err("too deep");
            assert!(error.problem.contains("nested"), "{error}");
            assert!(error.line.is_some(), "{error}");
        }
        assert_eq!(check(&format!("\n\n{}", "(".repeat(65))).expect_err("too deep").line, Some(3));
    }

    #[test]
    fn brackets_in_strings_and_comments_do_not_count() {
        let many = "(".repeat(100);
        for text in [
            format!("\"{many}\""),
            format!("r#\"{many}\" {many}\"#"),
            format!("// {many}"),
            format!("/* /* */ {many} */"),
            "'('".repeat(100),
            "(\"\\\"(\")".repeat(100),
        ] {
            assert_eq!(check(&text), Ok(()), "{text}");
        }
    }
}
