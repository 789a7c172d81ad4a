//! The tree of nodes: which nodes the scene shows, in what order, and where each one is at rest.

use super::document::{self, Document};
use super::errors::Findings;
use glam::{Affine3A, Mat4, Quat, Vec3};

/// How deep nodes may be nested.
const MOST_DEPTH: usize = 256;

/// Where a node is within its parent while nothing moves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rest {
    /// Given as a matrix, so that it cannot be animated.
    Matrix(Affine3A),
    /// Given by its parts.
    Parts { at: Vec3, turn: Quat, scale: Vec3 },
}

impl Rest {
    pub(crate) fn place(self) -> Affine3A {
        match self {
            Self::Matrix(at) => at,
            Self::Parts { at, turn, scale } => Affine3A::from_scale_rotation_translation(scale, turn, at),
        }
    }
}

/// A node that is shown.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Visited {
    /// Its index in the file.
    pub(crate) node: usize,
    /// Its parent's position in the same list, which is always before its own.
    pub(crate) parent: Option<usize>,
}

/// Every node's place at rest; one that is wrong stands at its parent.
pub(crate) fn rests(document: &Document, findings: &mut Findings) -> Vec<Rest> {
    let rest = |(index, node): (usize, &document::Node)| {
        let place = format!("nodes[{index}]");
        rest_of(node).unwrap_or_else(|(part, message)| {
            findings.wrong(format!("{place}{part}"), message);
            Rest::Matrix(Affine3A::IDENTITY)
        })
    };
    document.nodes.iter().enumerate().map(rest).collect()
}

fn rest_of(node: &document::Node) -> Result<Rest, (&'static str, String)> {
    let numbers =
        [node.matrix.as_ref().map(<[f32; 16]>::as_slice), node.translation.as_ref().map(<[f32; 3]>::as_slice)];
    let more = [node.rotation.as_ref().map(<[f32; 4]>::as_slice), node.scale.as_ref().map(<[f32; 3]>::as_slice)];
    for ((name, most), values) in [(".matrix", 1e9), (".translation", 1e9), (".rotation", 2.0), (".scale", 1e9)]
        .into_iter()
        .zip(numbers.into_iter().chain(more))
    {
        if let Some(bad) = values.into_iter().flatten().find(|x| !(0.0..=most).contains(&x.abs())) {
            return Err((name, format!("it has {bad}; expected −{most} to {most}")));
        }
    }
    if let Some(matrix) = node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            return Err((
                ".matrix",
                "it has parts of its own beside its translation, rotation or scale; expected one or the other"
                    .to_owned(),
            ));
        }
        let matrix = Mat4::from_cols_array(&matrix);
        if !matrix.row(3).abs_diff_eq(glam::Vec4::W, 1e-4) {
            return Err((".matrix", format!("its last row is {}; expected 0, 0, 0, 1", matrix.row(3))));
        }
        return Ok(Rest::Matrix(Affine3A::from_mat4(matrix)));
    }
    let turn = match node.rotation.map(glam::Vec4::from) {
        None => Quat::IDENTITY,
        Some(turn) => Quat::from_vec4(
            turn.try_normalize().ok_or_else(|| (".rotation", "it is a quaternion of length zero".to_owned()))?,
        ),
    };
    let scale = node.scale.map_or(Vec3::ONE, Vec3::from);
    Ok(Rest::Parts { at: node.translation.map_or(Vec3::ZERO, Vec3::from), turn, scale })
}

/// The nodes of the scene, parents first. Nodes must form trees (glTF 2.0, §3.5.2).
pub(crate) fn visited(document: &Document, findings: &mut Findings) -> Vec<Visited> {
    let count = document.nodes.len();
    let mut parents: Vec<Option<usize>> = vec![None; count];
    let mut sound = true;
    for (index, node) in document.nodes.iter().enumerate() {
        for (i, &child) in node.children.iter().enumerate() {
            let place = format!("nodes[{index}].children[{i}]");
            match parents.get_mut(child) {
                None => findings.wrong(place, format!("there is no node {child}; the file has {count}")),
                Some(Some(other)) => {
                    findings.wrong(
                        place,
                        format!("node {child} is a child of node {other} already; nodes must form a tree"),
                    );
                }
                Some(parent) => {
                    *parent = Some(index);
                    continue;
                }
            }
            sound = false;
        }
    }
    for index in nodes_in_cycles(&parents) {
        findings.wrong(format!("nodes[{index}]"), "it is its own ancestor: its children lead back to it");
        sound = false;
    }
    if !sound {
        return Vec::new();
    }
    let Some(roots) = roots(document, &parents, findings) else { return Vec::new() };

    let mut visited: Vec<Visited> = Vec::new();
    let mut depths: Vec<usize> = Vec::new();
    let mut pending: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
    while let Some((node, parent)) = pending.pop() {
        let depth = parent.map_or(0, |parent| depths[parent] + 1);
        if depth > MOST_DEPTH {
            findings.wrong(format!("nodes[{node}]"), format!("it is nested more than {MOST_DEPTH} deep"));
            return Vec::new();
        }
        visited.push(Visited { node, parent });
        depths.push(depth);
        let position = visited.len() - 1;
        pending.extend(document.nodes[node].children.iter().rev().map(|&child| (child, Some(position))));
    }
    visited
}

/// Nodes from which their parents lead back to themselves, each at most once.
fn nodes_in_cycles(parents: &[Option<usize>]) -> Vec<usize> {
    // Every chain of parents ends at a root, at a chain that was followed before, or at itself.
    let mut chain_of = vec![usize::MAX; parents.len()];
    let mut found = Vec::new();
    for start in 0..parents.len() {
        let mut next = Some(start);
        while let Some(node) = next.filter(|&node| chain_of[node] == usize::MAX) {
            chain_of[node] = start;
            next = parents[node];
        }
        if let Some(node) = next.filter(|&node| chain_of[node] == start) {
            found.push(node);
        }
    }
    found
}

/// The nodes with which the scene begins: those of the scene that the file names, else of the first, else all that have
/// no parent.
fn roots(document: &Document, parents: &[Option<usize>], findings: &mut Findings) -> Option<Vec<usize>> {
    let index = document.scene.unwrap_or(0);
    let Some(scene) = document.scenes.get(index) else {
        if document.scene.is_some() {
            findings.wrong("scene", format!("there is no scene {index}; the file has {}", document.scenes.len()));
            return None;
        }
        return Some((0..parents.len()).filter(|&node| parents[node].is_none()).collect());
    };
    let mut seen = vec![false; parents.len()];
    let mut sound = true;
    for (i, &node) in scene.nodes.iter().enumerate() {
        let place = format!("scenes[{index}].nodes[{i}]");
        match (seen.get_mut(node), parents.get(node)) {
            (Some(seen), _) if *seen => findings.wrong(place, format!("node {node} is named twice")),
            (Some(_), Some(Some(parent))) => {
                findings
                    .wrong(place, format!("node {node} is a child of node {parent}; expected a node without a parent"));
            }
            (Some(seen), _) => {
                *seen = true;
                continue;
            }
            (None, _) => findings.wrong(place, format!("there is no node {node}; the file has {}", parents.len())),
        }
        sound = false;
    }
    sound.then(|| scene.nodes.clone())
}
