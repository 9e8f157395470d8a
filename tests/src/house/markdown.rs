//! The parts of Markdown that the checks read: code spans, links and anchors of headings.

use std::collections::{BTreeMap, BTreeSet};

/// Text between backticks, or the target of a link, with its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// Line number, from 1.
    pub line: usize,
    /// Text of the span.
    pub text: String,
}

/// Lines outside fenced code, with their numbers.
fn prose(source: &str) -> Vec<(usize, &str)> {
    let mut fence: Option<&str> = None;
    let mut lines = Vec::new();
    for (index, line) in source.lines().enumerate() {
        let text = line.trim_start();
        let mark = ["```", "~~~"].into_iter().find(|mark| text.starts_with(mark));
        match (fence, mark) {
            (None, Some(mark)) => fence = Some(mark),
            (Some(open), Some(mark)) if open == mark => fence = None,
            (None, None) => lines.push((index + 1, line)),
            _ => {}
        }
    }
    lines
}

/// Code spans outside fenced code. A span may not go over the end of a line.
pub fn code_spans(source: &str) -> Vec<Span> {
    let mut found = Vec::new();
    for (line, text) in prose(source) {
        for (index, part) in text.replace("``", "`").split('`').enumerate() {
            if index % 2 == 1 {
                found.push(Span { line, text: part.to_string() });
            }
        }
    }
    found
}

/// Targets of the links and images outside code.
pub fn links(source: &str) -> Vec<Span> {
    let mut found = Vec::new();
    for (line, text) in prose(source) {
        let plain: String = text.split('`').step_by(2).collect::<Vec<_>>().join("code");
        for part in plain.split("](").skip(1) {
            let Some((target, _)) = part.split_once(')') else { continue };
            let target = target.split_whitespace().next().unwrap_or_default();
            let text = target.trim_matches(['<', '>']).to_string();
            found.push(Span { line, text });
        }
        if let Some((label, target)) = plain.trim_start().split_once("]: ")
            && label.starts_with('[')
        {
            let text = target.split_whitespace().next().unwrap_or_default().to_string();
            found.push(Span { line, text });
        }
    }
    found
}

/// Anchors of a document: headings as GitHub names them, and `id="..."` of HTML elements.
pub fn anchors(source: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (_, line) in prose(source) {
        for mark in ["id=\"", "name=\""] {
            let ids = line.split(mark).skip(1).filter_map(|part| part.split('"').next());
            found.extend(ids.map(String::from));
        }
        let level = line.chars().take_while(|&c| c == '#').count();
        if level == 0 || level > 6 || !line[level..].starts_with(' ') {
            continue;
        }
        let slug = slug(&line[level..]);
        let count = counts.entry(slug.clone()).or_default();
        found.insert(if *count == 0 { slug } else { format!("{slug}-{count}") });
        *count += 1;
    }
    found
}

/// Anchor of a heading: lower case, spaces as hyphens, punctuation left out.
pub fn slug(heading: &str) -> String {
    let mut text = heading.trim().trim_end_matches('#').trim().to_string();
    while let Some(start) = text.find("](")
        && let Some(length) = text[start..].find(')')
    {
        text.replace_range(start..start + length + 1, "");
    }
    let kept = text.chars().filter(|&c| c.is_alphanumeric() || " -_".contains(c));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_and_links_outside_fences_are_found() {
        let source = "`a/b` and [x](c.md#d \"t\")\n```\n`no` [no](no)\n```\n![`y`](e.png)\n[z]: f.md\n";
        let spans: Vec<String> = code_spans(source).into_iter().map(|span| span.text).collect();
        assert_eq!(spans, ["a/b", "y"]);
        let links: Vec<(usize, String)> = links(source).into_iter().map(|span| (span.line, span.text)).collect();
        let expected = [(1, "c.md#d"), (5, "e.png"), (6, "f.md")];
        assert_eq!(links, expected.map(|(line, text)| (line, text.to_string())));
    }

    #[test]
    fn headings_become_anchors() {
        let found = anchors("# A `b_c`: [D](e), f!\n## Same\n## Same\n<a id=\"own\"></a>\n");
        for anchor in ["a-b_c-d-f", "same", "same-1", "own"] {
            assert!(found.contains(anchor), "{anchor} in {found:?}");
        }
    }
}
