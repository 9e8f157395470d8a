//! Directed graphs of imports and their circles.

use std::collections::{BTreeMap, BTreeSet};

/// Names with the names that each imports.
pub type Graph = BTreeMap<String, BTreeSet<String>>;

/// Strongly connected components of more than one name, each sorted, the largest first.
pub fn circles(graph: &Graph) -> Vec<Vec<String>> {
    let reached: BTreeMap<&String, BTreeSet<&String>> =
        graph.keys().map(|name| (name, reachable(graph, name))).collect();
    let mut found: Vec<Vec<String>> = Vec::new();
    let mut done: BTreeSet<&String> = BTreeSet::new();
    for (name, targets) in &reached {
        if !targets.contains(name) || !done.insert(name) {
            continue;
        }
        let mutual = |other: &&&String| reached.get(**other).is_some_and(|r| r.contains(name));
        let members: Vec<&String> = targets.iter().filter(mutual).copied().collect();
        done.extend(&members);
        if members.len() > 1 {
            found.push(members.into_iter().cloned().collect());
        }
    }
    found.sort_by_key(|members| (std::cmp::Reverse(members.len()), members.clone()));
    found
}

/// Names that are reached from one by one import or more.
fn reachable<'a>(graph: &'a Graph, start: &'a String) -> BTreeSet<&'a String> {
    let mut found = BTreeSet::new();
    let mut open = vec![start];
    while let Some(name) = open.pop() {
        for next in graph.get(name).into_iter().flatten() {
            if found.insert(next) {
                open.push(next);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_more_than_one_name_are_circles() {
        let edges = [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("d", "d"), ("e", "f")];
        let mut graph = Graph::new();
        for (from, to) in edges.iter().chain([&("f", "e"), &("x", "a")]) {
            graph.entry(from.to_string()).or_default().insert(to.to_string());
        }
        assert_eq!(circles(&graph), vec![vec!["a", "b", "c"], vec!["e", "f"]]);
    }
}
