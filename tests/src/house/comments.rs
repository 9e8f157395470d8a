//! Comments of Rust source: a scanner, the width of comment lines and the beginnings of sentences.

use std::iter::Peekable;
use std::str::CharIndices;

/// Maximum width of a line that contains a comment, in characters.
pub const MAX_WIDTH: usize = 100;

/// Beginnings of a sentence that the style guide excludes.
pub const VAGUE_OPENINGS: [&str; 3] = ["What ", "The same ", "Of "];

/// Kind of a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `//` on a line of its own.
    Plain,
    /// `///`, documentation of the next item.
    Outer,
    /// `//!`, documentation of the enclosing item.
    Inner,
    /// `//` after code on the same line.
    Trailing,
    /// A line of `/* ... */`.
    Block,
}

/// One line of one comment.
#[derive(Clone, Debug)]
pub struct Comment {
    /// Line number, from 1.
    pub line: usize,
    /// Kind of the comment.
    pub kind: Kind,
    /// Text without the comment marker.
    pub text: String,
}

/// A sentence of a comment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sentence {
    /// Line number of the first word, from 1.
    pub line: usize,
    /// Text on one line.
    pub text: String,
}

type Chars<'a> = Peekable<CharIndices<'a>>;

/// Read all comments of a source text, one entry a line, in the order of lines.
pub fn read(source: &str) -> Vec<Comment> {
    let mut found = Vec::new();
    let mut chars = source.char_indices().peekable();
    let (mut line, mut code_before) = (1, false);
    let mut previous = ' ';
    while let Some((at, c)) = chars.next() {
        let next = chars.peek().map_or(' ', |&(_, c)| c);
        match c {
            '\n' => {
                line += 1;
                code_before = false;
            }
            '/' if next == '/' => {
                let rest = &source[at..];
                let text = rest.lines().next().unwrap_or_default();
                found.push(line_comment(text, line, code_before));
                while chars.next_if(|&(_, c)| c != '\n').is_some() {}
            }
            '/' if next == '*' => block_comment(source, at, &mut chars, &mut line, &mut found),
            '"' => skip_string(&mut chars, &mut line),
            'r' if "#\"".contains(next) && (!is_word(previous) || "bc".contains(previous)) => {
                skip_raw_string(source, &mut chars, &mut line);
            }
            '\'' => skip_char(&mut chars, &mut line),
            _ => {}
        }
        if !c.is_whitespace() {
            code_before = true;
        }
        previous = c;
    }
    found
}

/// Line numbers, with widths, of the lines that contain a comment and exceed [`MAX_WIDTH`].
pub fn wide_lines(source: &str) -> Vec<(usize, usize)> {
    let mut numbers: Vec<usize> = read(source).iter().map(|comment| comment.line).collect();
    numbers.dedup();
    let lines: Vec<&str> = source.lines().collect();
    let width = |number: usize| lines.get(number - 1).map_or(0, |line| line.chars().count());
    let widths = numbers.into_iter().map(|number| (number, width(number)));
    widths.filter(|&(_, width)| width > MAX_WIDTH).collect()
}

/// Sentences that begin with one of [`VAGUE_OPENINGS`].
pub fn vague_sentences(source: &str) -> Vec<Sentence> {
    let vague = |s: &Sentence| VAGUE_OPENINGS.iter().any(|opening| s.text.starts_with(opening));
    sentences(source).into_iter().filter(vague).collect()
}

/// Sentences of all comments. Consecutive lines of one kind are joined; a blank line, a list item,
/// a heading and a table row end a paragraph; fenced code is left out.
pub fn sentences(source: &str) -> Vec<Sentence> {
    let mut found = Vec::new();
    let mut paragraph: Vec<(usize, String)> = Vec::new();
    let mut in_fence = false;
    let mut last: Option<(usize, Kind)> = None;
    for comment in read(source) {
        let joins =
            last.is_some_and(|(line, kind)| line + 1 == comment.line && kind == comment.kind && kind != Kind::Trailing);
        if !joins {
            split_sentences(&mut paragraph, &mut found);
            in_fence = false;
        }
        last = Some((comment.line, comment.kind));
        let text = comment.text.trim();
        if text.starts_with("```") {
            split_sentences(&mut paragraph, &mut found);
            in_fence = !in_fence;
            continue;
        }
        if in_fence {
            continue;
        }
        if text.is_empty() || starts_paragraph(text) {
            split_sentences(&mut paragraph, &mut found);
        }
        if !text.is_empty() {
            paragraph.push((comment.line, text.to_string()));
        }
    }
    split_sentences(&mut paragraph, &mut found);
    found
}

fn starts_paragraph(text: &str) -> bool {
    let number = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let numbered = number.len() < text.len() && number.starts_with(". ");
    numbered || ["- ", "* ", "#", "|"].iter().any(|mark| text.starts_with(mark))
}

/// Split the lines of a paragraph into sentences; empties the paragraph.
fn split_sentences(paragraph: &mut Vec<(usize, String)>, found: &mut Vec<Sentence>) {
    let mut text = String::new();
    let mut first_line = 0;
    for (line, words) in paragraph
        .drain(..)
        .flat_map(|(line, text)| text.split_whitespace().map(|word| (line, word.to_string())).collect::<Vec<_>>())
    {
        let word = if text.is_empty() { words.trim_start_matches(is_markup) } else { &words };
        if word.is_empty() {
            continue;
        }
        if text.is_empty() {
            first_line = line;
        } else {
            text.push(' ');
        }
        text.push_str(word);
        if word.ends_with(['.', '!', '?', ':']) {
            found.push(Sentence { line: first_line, text: std::mem::take(&mut text) });
        }
    }
    if !text.is_empty() {
        found.push(Sentence { line: first_line, text });
    }
}

fn is_markup(c: char) -> bool {
    "-*#>|([\"'_".contains(c)
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn line_comment(text: &str, line: usize, code_before: bool) -> Comment {
    let (kind, mark) = if code_before {
        (Kind::Trailing, 2)
    } else if text.starts_with("//!") {
        (Kind::Inner, 3)
    } else if text.starts_with("///") && !text.starts_with("////") {
        (Kind::Outer, 3)
    } else {
        (Kind::Plain, 2)
    };
    Comment { line, kind, text: text[mark..].to_string() }
}

/// Read a block comment, nested ones included; `chars` stands after its first `/`.
fn block_comment(source: &str, start: usize, chars: &mut Chars, line: &mut usize, found: &mut Vec<Comment>) {
    let (mut depth, mut end) = (0, source.len());
    let mut previous = '/';
    for (at, c) in chars.by_ref() {
        match (previous, c) {
            ('/', '*') => (depth, previous) = (depth + 1, ' '),
            ('*', '/') => (depth, previous) = (depth - 1, ' '),
            _ => previous = c,
        }
        if depth == 0 {
            end = at + 1;
            break;
        }
    }
    for (index, text) in source[start..end].lines().enumerate() {
        if index > 0 {
            *line += 1;
        }
        let text = text.trim().trim_start_matches("/*").trim_end_matches("*/");
        let text = text.trim_start_matches('*').to_string();
        found.push(Comment { line: *line, kind: Kind::Block, text });
    }
}

/// Skip a string literal; `chars` stands after its opening quote.
fn skip_string(chars: &mut Chars, line: &mut usize) {
    while let Some((_, c)) = chars.next() {
        match c {
            '\n' => *line += 1,
            '"' => return,
            '\\' if chars.next().is_some_and(|(_, c)| c == '\n') => *line += 1,
            _ => {}
        }
    }
}

/// Skip a raw string literal; `chars` stands after its `r`. A raw identifier is left as it is.
fn skip_raw_string(source: &str, chars: &mut Chars, line: &mut usize) {
    let Some(&(start, _)) = chars.peek() else { return };
    let hashes = source[start..].chars().take_while(|&c| c == '#').count();
    if !source[start + hashes..].starts_with('"') {
        return;
    }
    let closing = format!("\"{}", "#".repeat(hashes));
    let body = start + hashes + 1;
    let end = source[body..].find(&closing).map_or(source.len(), |at| body + at + closing.len());
    *line += source[start..end].matches('\n').count();
    while chars.next_if(|&(at, _)| at < end).is_some() {}
}

/// Skip a character literal, or the quote of a lifetime; `chars` stands after the quote.
fn skip_char(chars: &mut Chars, line: &mut usize) {
    let mut ahead = chars.clone();
    match ahead.next() {
        Some((_, '\\')) => {
            chars.next();
            chars.next();
            while chars.next_if(|&(_, c)| c != '\'' && c != '\n').is_some() {}
            chars.next_if(|&(_, c)| c == '\'');
        }
        Some((_, c)) if ahead.next().is_some_and(|(_, close)| close == '\'') => {
            *line += usize::from(c == '\n');
            chars.next();
            chars.next();
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(source: &str) -> Vec<(usize, Kind)> {
        read(source).into_iter().map(|comment| (comment.line, comment.kind)).collect()
    }

    #[test]
    fn comment_kinds_and_lines_are_read() {
        let source = "//! a\n\n/// b\nfn f() {} // c\n// d\n/* e\n f */\nfn g() {}\n// h\n";
        let expected = vec![
            (1, Kind::Inner),
            (3, Kind::Outer),
            (4, Kind::Trailing),
            (5, Kind::Plain),
            (6, Kind::Block),
            (7, Kind::Block),
            (9, Kind::Plain),
        ];
        assert_eq!(lines(source), expected);
    }

    #[test]
    fn marks_inside_literals_are_no_comments() {
        let source = r####"
            const A: &str = "http://x \" // no";
            const B: &str = r#"// no " // no
                // no"#;
            const C: char = '"'; // line 5
            const D: &[u8] = br"// no";
            fn f<'a>(x: &'a str) -> char { '\'' } // line 7
            let r#type = 1; // line 8
        "####;
        let numbers: Vec<usize> = read(source).iter().map(|comment| comment.line).collect();
        assert_eq!(numbers, vec![5, 7, 8]);
    }

    #[test]
    fn wide_lines_count_characters_with_the_code_before() {
        let source = format!("{} // x\n// {}\n// {}\n", "a".repeat(97), "b".repeat(97), "µ".repeat(98));
        assert_eq!(wide_lines(&source), vec![(1, 102), (3, 101)]);
    }

    #[test]
    fn sentences_join_lines_and_end_at_paragraphs() {
        let source = "/// One line. What\n/// follows: The same again\n///\n/// Of course\n\
                      fn f() {}\n\
                      /// ```\n/// What code.\n/// ```\n/// - **Of** item\n";
        let found = vague_sentences(source);
        let lines: Vec<usize> = found.iter().map(|sentence| sentence.line).collect();
        assert_eq!(lines, vec![1, 2, 4]);
        assert_eq!(found[0].text, "What follows:");
    }
}
