//! Groups: names and addresses, in B-trees of version 1 or in link messages.

use super::object::{LINK, Object, SYMBOLS};
use super::{Hdf5File, newer};
use crate::Error;
use crate::formats::bytes::{damaged, length, part, text};

impl<'a> Hdf5File<'a> {
    /// Names in a group, and addresses of their objects. Links to other places are not followed.
    pub(super) fn links(&mut self, group: &Object<'a>) -> Result<Vec<(String, usize)>, Error> {
        let mut links = Vec::new();
        if let Some(symbols) = group.first(SYMBOLS) {
            let (tree, heap) = (length(symbols, 0, 8, false)?, length(symbols, 8, 8, false)?);
            let names = self.heap(heap)?;
            for leaf in self.leaves(tree, 8)? {
                self.symbols(leaf.child, names, &mut links)?;
            }
        }
        if group.is_large()? {
            return Err(newer("a group of many data sets, in its newer form"));
        }
        for message in group.all(LINK) {
            links.extend(link(message)?);
        }
        Ok(links)
    }

    /// The names of a group, one after the other.
    fn heap(&self, at: usize) -> Result<&'a [u8], Error> {
        if part(self.bytes, at, 4)? != b"HEAP" {
            return Err(damaged(format!("no names stand at address {at}")));
        }
        part(self.bytes, self.number(at + 24, 8)?, self.number(at + 8, 8)?)
    }

    /// Adds the symbols of a leaf to `links`.
    fn symbols(&mut self, at: usize, names: &[u8], links: &mut Vec<(String, usize)>) -> Result<(), Error> {
        self.visit()?;
        if part(self.bytes, at, 4)? != b"SNOD" {
            return Err(damaged(format!("no symbols stand at address {at}")));
        }
        for k in 0..self.number(at + 6, 2)? {
            let entry = part(self.bytes, at + 8 + 40 * k, 40)?;
            // 2: a link to another name.
            if length(entry, 16, 4, false)? != 2 {
                let name = names.get(length(entry, 0, 8, false)?..).ok_or_else(|| damaged("a name behind its heap"))?;
                links.push((text(name), length(entry, 8, 8, false)?));
            }
        }
        Ok(())
    }

    /// The leaves below a node of a B-tree with keys of this length.
    pub(super) fn leaves(&mut self, root: usize, key: usize) -> Result<Vec<Leaf<'a>>, Error> {
        let mut leaves = Vec::new();
        let mut nodes = vec![(root, usize::MAX)];
        while let Some((at, above)) = nodes.pop() {
            self.visit()?;
            let level = self.number(at + 5, 1)?;
            if part(self.bytes, at, 4)? != b"TREE" || level >= above {
                return Err(damaged(format!("no node of a tree stands at address {at}")));
            }
            for k in 0..self.number(at + 6, 2)? {
                let place = at + 24 + k * (key + 8);
                let (key, child) = (part(self.bytes, place, key)?, self.number(place + key, 8)?);
                if level > 0 {
                    nodes.push((child, level));
                } else {
                    self.visit()?;
                    leaves.push(Leaf { key, child });
                }
            }
        }
        Ok(leaves)
    }
}

/// An entry of the lowest level of a tree.
pub(super) struct Leaf<'a> {
    pub(super) key: &'a [u8],
    /// Its address.
    pub(super) child: usize,
}

/// A link message: a name, and the address of its object; `None` for other kinds of link.
fn link(message: &[u8]) -> Result<Option<(String, usize)>, Error> {
    let flags = length(message, 1, 1, false)?;
    let kind = if flags & 8 > 0 { length(message, 2, 1, false)? } else { 0 };
    let at =
        2 + [(8, 1), (4, 8), (16, 1)].iter().map(|(flag, len)| if flags & flag > 0 { *len } else { 0 }).sum::<usize>();
    let width = 1 << (flags & 3);
    let len = length(message, at, width, false)?;
    let name = part(message, at + width, len)?;
    Ok(if kind == 0 { Some((text(name), length(message, at + width + len, 8, false)?)) } else { None })
}
