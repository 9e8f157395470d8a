//! Text of signatures and types on one line, with a fixed layout.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::ToTokens;

/// Text of a syntax element on one line.
pub fn text(element: &impl ToTokens) -> String {
    let mut printer = Printer { text: String::new(), glued: true };
    printer.print(element.to_token_stream());
    let trimmed = printer.text.trim_end().trim_end_matches(',');
    trimmed.replace(",)", ")").replace(",>", ">").replace(", )", ")")
}

struct Printer {
    text: String,
    /// True when the next token follows without a space.
    glued: bool,
}

impl Printer {
    fn push(&mut self, token: &str, glued: bool) {
        if !glued && !self.glued && !self.text.is_empty() {
            self.text.push(' ');
        }
        self.text.push_str(token);
        self.glued = false;
    }

    fn print(&mut self, stream: TokenStream) {
        let mut trees = stream.into_iter().peekable();
        while let Some(tree) = trees.next() {
            match tree {
                TokenTree::Group(group) => self.print_group(&group),
                TokenTree::Ident(ident) => self.push(&ident.to_string(), false),
                TokenTree::Literal(literal) => self.push(&literal.to_string(), false),
                TokenTree::Punct(first) => {
                    let mut operator = first.as_char().to_string();
                    let mut last = first;
                    while last.spacing() == proc_macro2::Spacing::Joint
                        && let Some(TokenTree::Punct(next)) = trees.peek()
                        && is_operator(&operator, next.as_char())
                    {
                        operator.push(next.as_char());
                        last = next.clone();
                        trees.next();
                    }
                    self.print_operator(&operator);
                }
            }
        }
    }

    fn print_operator(&mut self, operator: &str) {
        match operator {
            "," | ";" | ":" | "?" => self.push(operator, true),
            ">" => self.push(operator, true),
            "." | "::" | "<" | ".." | "..=" => {
                let after_word = self.text.ends_with(|c: char| c.is_alphanumeric() || c == '_');
                self.push(operator, operator != "<" || after_word || self.text.ends_with(':'));
                self.glued = true;
            }
            "&" | "'" | "#" | "!" | "*" => {
                self.push(operator, false);
                self.glued = true;
            }
            _ => self.push(operator, false),
        }
    }

    fn print_group(&mut self, group: &proc_macro2::Group) {
        let (open, close) = match group.delimiter() {
            Delimiter::Parenthesis => ("(", ")"),
            Delimiter::Bracket => ("[", "]"),
            Delimiter::Brace => ("{ ", " }"),
            Delimiter::None => ("", ""),
        };
        let call = group.delimiter() == Delimiter::Parenthesis
            && self.text.ends_with(|c: char| c.is_alphanumeric() || ">_!".contains(c))
            && !self.text.ends_with("->");
        self.push(open, call);
        self.glued = true;
        self.print(group.stream());
        self.push(close, true);
    }
}

/// True if `next` continues the operator `so_far`.
fn is_operator(so_far: &str, next: char) -> bool {
    let both = format!("{so_far}{next}");
    ["::", "->", "=>", "..", "...", "..=", "==", "&&", "||"].contains(&both.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(source: &str) -> String {
        text(&syn::parse_str::<syn::Signature>(source).unwrap())
    }

    #[test]
    fn signatures_have_a_fixed_layout() {
        let cases = [
            "fn f(&self, x: &mut Vec<f64>) -> Option<(usize, f64)>",
            "fn g<'a, T: Into<crate::A> + Copy>(x: &'a [T; 3]) -> impl Iterator<Item = &'a T> + 'a",
            "fn h(f: impl Fn(f64, usize) -> bool) where f64: Copy",
            "const fn k(&self) -> <Self as Trait>::Out",
        ];
        for case in cases {
            assert_eq!(printed(case), case);
        }
        assert_eq!(printed("fn f(\n a : f64,\n b:u32, ) -> ( )"), "fn f(a: f64, b: u32) -> ()");
    }
}
