//! Who is on the bus.

/// A node of the bus. Each has one transmit queue, first in, first out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// The control stack.
    Stack,
    /// The right wheel's drive.
    Right,
    /// The left wheel's drive.
    Left,
    /// Somebody who does not belong here. It is on the bus only while a fault
    /// makes it babble, and then next to the stack.
    Intruder,
}

/// A set of nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nodes(u8);

impl Node {
    /// All of them, in the order in which ties are broken.
    pub const ALL: [Self; 4] = [Self::Stack, Self::Right, Self::Left, Self::Intruder];
}

impl Nodes {
    /// Nobody.
    pub const NONE: Self = Self(0);
    /// Both drives.
    pub const DRIVES: Self = Self(1 << Node::Right as u8 | 1 << Node::Left as u8);
    /// Whoever there is.
    pub const ALL: Self = Self(0b1111);

    /// One node alone.
    pub const fn only(node: Node) -> Self {
        Self(1 << node as u8)
    }

    /// Whether a node is one of them.
    pub const fn contains(self, node: Node) -> bool {
        self.0 & 1 << node as u8 != 0
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// These and those.
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// These but for those.
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// Those of these that are among others.
    pub const fn among(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    /// The only one, if there is only one.
    pub const fn single(self) -> Option<Node> {
        if self.0.is_power_of_two() { Some(Node::ALL[self.0.trailing_zeros() as usize]) } else { None }
    }

    /// Each of them.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = Node> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let node = *Node::ALL.get(left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(node)
        })
    }
}

impl FromIterator<Node> for Nodes {
    fn from_iter<I: IntoIterator<Item = Node>>(nodes: I) -> Self {
        nodes.into_iter().fold(Self::NONE, |all, node| all.and(Self::only(node)))
    }
}
