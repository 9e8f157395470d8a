//! Comparison of two versions of a source file by their tokens, comments left out.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::path::Path;
use std::process::Command;
use std::str::FromStr;

/// A token as text, with its line.
#[derive(Clone, Debug)]
pub struct Token {
    /// Text of the token; a `~` follows punctuation that the next character continues.
    pub text: String,
    /// Line number, from 1.
    pub line: usize,
}

/// First place where two token sequences differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Token of the old version with its line; `end of file` past the last one.
    pub old: (String, usize),
    /// Token of the new version with its line; `end of file` past the last one.
    pub new: (String, usize),
}

/// The other version that files are compared with.
#[derive(Clone, Copy, Debug)]
pub enum Reference<'a> {
    /// A revision of the Git repository.
    Revision(&'a str),
    /// A directory that holds a copy of the repository.
    Directory(&'a Path),
}

/// Tokens of a source text without comments and documentation comments.
pub fn tokens(source: &str) -> Result<Vec<Token>, String> {
    let first = source.lines().next().unwrap_or_default();
    let body = if first.starts_with("#!/") { &source[first.len()..] } else { source };
    let stream = TokenStream::from_str(body)
        .map_err(|error| format!("line {}: cannot be read as Rust tokens", error.span().start().line))?;
    let mut found = Vec::new();
    flatten(stream, &mut found);
    Ok(found)
}

/// First difference between the tokens of two source texts.
pub fn first_difference(old: &str, new: &str) -> Result<Option<Difference>, String> {
    let old = tokens(old).map_err(|error| format!("old version, {error}"))?;
    let new = tokens(new).map_err(|error| format!("new version, {error}"))?;
    let count = old.len().max(new.len());
    let text = |list: &[Token], at: usize| list.get(at).map(|token| token.text.clone());
    let Some(at) = (0..count).find(|&at| text(&old, at) != text(&new, at)) else {
        return Ok(None);
    };
    let place = |list: &[Token]| match list.get(at) {
        Some(token) => (token.text.clone(), token.line),
        None => ("end of file".to_string(), list.last().map_or(0, |token| token.line)),
    };
    Ok(Some(Difference { old: place(&old), new: place(&new) }))
}

/// Compare files of a working tree with another version; one line of text for each that differs.
pub fn compare_files(root: &Path, reference: Reference, files: &[String]) -> Vec<String> {
    let mut report = Vec::new();
    for file in files {
        let new = std::fs::read_to_string(root.join(file)).map_err(|error| error.to_string());
        let old = read_reference(root, reference, file);
        let outcome = old.and_then(|old| new.and_then(|new| first_difference(&old, &new)));
        match outcome {
            Ok(None) => {}
            Ok(Some(Difference { old, new })) => {
                report.push(format!("{file}:{}: `{}` was `{}` at line {}", new.1, new.0, old.0, old.1))
            }
            Err(error) => report.push(format!("{file}: {error}")),
        }
    }
    report
}

fn read_reference(root: &Path, reference: Reference, file: &str) -> Result<String, String> {
    match reference {
        Reference::Directory(directory) => std::fs::read_to_string(directory.join(file))
            .map_err(|error| format!("{}: {error}", directory.join(file).display())),
        Reference::Revision(revision) => {
            let object = format!("{revision}:./{file}");
            let output = Command::new("git").arg("-C").arg(root).args(["show", &object]).output();
            let output = output.map_err(|error| format!("git: {error}"))?;
            if !output.status.success() {
                return Err(String::from_utf8_lossy(&output.stderr).trim().to_string());
            }
            String::from_utf8(output.stdout).map_err(|error| error.to_string())
        }
    }
}

/// Append the tokens of a stream, groups opened up, documentation comments dropped.
fn flatten(stream: TokenStream, found: &mut Vec<Token>) {
    let trees: Vec<TokenTree> = stream.into_iter().collect();
    let mut at = 0;
    while at < trees.len() {
        let skipped = doc_comment_length(&trees[at..]);
        if skipped > 0 {
            at += skipped;
            continue;
        }
        let line = trees[at].span().start().line;
        match &trees[at] {
            TokenTree::Group(group) => {
                let (open, close) = delimiters(group.delimiter());
                found.push(Token { text: open.to_string(), line });
                flatten(group.stream(), found);
                let line = group.span_close().end().line;
                found.push(Token { text: close.to_string(), line });
            }
            TokenTree::Punct(punct) => {
                let follows = matches!(trees.get(at + 1), Some(TokenTree::Punct(_)));
                let joint = follows && punct.spacing() == Spacing::Joint;
                let mark = if joint { "~" } else { "" };
                found.push(Token { text: format!("{}{mark}", punct.as_char()), line });
            }
            other => found.push(Token { text: other.to_string(), line }),
        }
        at += 1;
    }
}

fn delimiters(delimiter: Delimiter) -> (&'static str, &'static str) {
    match delimiter {
        Delimiter::Parenthesis => ("(", ")"),
        Delimiter::Brace => ("{", "}"),
        Delimiter::Bracket => ("[", "]"),
        Delimiter::None => ("", ""),
    }
}

/// Number of trees that a leading `#[doc = "..."]` or `#![doc = "..."]` takes; 0 if there is none.
fn doc_comment_length(trees: &[TokenTree]) -> usize {
    let punct = |at: usize, c: char| match trees.get(at) {
        Some(TokenTree::Punct(punct)) => punct.as_char() == c,
        _ => false,
    };
    if !punct(0, '#') {
        return 0;
    }
    let at = if punct(1, '!') { 2 } else { 1 };
    match trees.get(at) {
        Some(TokenTree::Group(group)) if is_doc(group) => at + 1,
        _ => 0,
    }
}

fn is_doc(group: &proc_macro2::Group) -> bool {
    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
    group.delimiter() == Delimiter::Bracket
        && matches!(&inner[..], [TokenTree::Ident(name), TokenTree::Punct(equals),
            TokenTree::Literal(_)] if name == "doc" && equals.as_char() == '=')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_layout_do_not_count() {
        let old = "//! Old.\n/// What.\nfn f() -> f64 { /* a */ 1.0 } // b\n";
        let new = "//! New\n//! lines.\nfn f() -> f64 {\n    1.0\n}\n";
        assert_eq!(first_difference(old, new), Ok(None));
    }

    #[test]
    fn comments_inside_macros_do_not_count() {
        let old = "m! { /// a\n x: 1, #[doc = \"b\"] y }";
        assert_eq!(first_difference(old, "m! { x: 1, y }"), Ok(None));
    }

    #[test]
    fn other_attributes_count() {
        assert!(first_difference("#[doc(hidden)] fn f() {}", "fn f() {}").unwrap().is_some());
    }

    #[test]
    fn a_changed_literal_is_found_with_its_lines() {
        let difference = first_difference("fn f() {\n g(\"a\") }", "fn f() { g(\"b\") }").unwrap();
        let expected = Difference { old: ("\"a\"".into(), 2), new: ("\"b\"".into(), 1) };
        assert_eq!(difference, Some(expected));
    }

    #[test]
    fn operators_are_told_apart_by_spacing() {
        assert!(first_difference("a && b", "a & & b").unwrap().is_some());
        assert!(first_difference("a - 1", "a-1").unwrap().is_none());
    }
}
