//! Searches for an order that keeps all rules. Each pair of faces has one answer: the first is above the second, or not. An
//! answer that does not follow from others is tried both ways.

/// A statement on a pair of faces: the first is above the second, or the other way round.
#[derive(Clone, Copy)]
pub(super) struct Literal {
    pub(super) pair: usize,
    pub(super) is_reversed: bool,
}

/// A condition on the answers to up to four questions.
#[derive(Clone, Copy)]
pub(super) struct Rule {
    pairs: [usize; 4],
    len: usize,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// The number of pairs whose first face is above is odd, or even.
    Parity { is_odd: bool },
    /// Not all three statements have the same answer; bit k is set if statement k is reversed.
    NotAlike { reversed: u8 },
}

impl Rule {
    fn parity<const N: usize>(literals: [Literal; N], is_odd: bool) -> Self {
        let reversed = literals.iter().filter(|literal| literal.is_reversed);
        let is_odd = is_odd != (reversed.count() % 2 == 1);
        Self::new(literals, Kind::Parity { is_odd })
    }

    fn new<const N: usize>(literals: [Literal; N], kind: Kind) -> Self {
        let mut pairs = [0; 4];
        for (pair, literal) in pairs.iter_mut().zip(&literals) {
            *pair = literal.pair;
        }
        Self {
            pairs,
            len: N,
            kind,
        }
    }

    /// The statement has this answer.
    pub(super) fn is(literal: Literal, answer: bool) -> Self {
        Self::parity([literal], answer)
    }

    /// Both statements have the same answer.
    pub(super) fn alike(a: Literal, b: Literal) -> Self {
        Self::parity([a, b], false)
    }

    /// An even number of the statements is true.
    pub(super) fn even(literals: [Literal; 4]) -> Self {
        Self::parity(literals, false)
    }

    /// The statements do not all have the same answer.
    pub(super) fn not_alike(literals: [Literal; 3]) -> Self {
        let bits = literals.iter().enumerate();
        let reversed = bits
            .map(|(k, literal)| u8::from(literal.is_reversed) << k)
            .sum();
        Self::new(literals, Kind::NotAlike { reversed })
    }

    /// Returns the pairs of faces of which the rule says something.
    pub(super) fn pairs(&self) -> &[usize] {
        &self.pairs[..self.len]
    }

    /// Returns what follows from the answers so far.
    fn follows(&self, answers: &[Option<bool>]) -> Follows {
        let pairs = self.pairs();
        let mut open = pairs.iter().filter(|&&pair| answers[pair].is_none());
        let next = open.next().copied();
        if open.next().is_some() {
            return Follows::Nothing;
        }
        let of = |pair: &usize| answers[*pair];
        let answer = match self.kind {
            Kind::Parity { is_odd } => {
                let above = pairs.iter().filter(|pair| of(pair) == Some(true));
                (above.count() % 2 == 1) != is_odd
            }
            Kind::NotAlike { reversed } => {
                let is_reversed = |k: usize| reversed >> k & 1 == 1;
                let known = pairs.iter().enumerate();
                let mut known = known.filter_map(|(k, pair)| Some(of(pair)? != is_reversed(k)));
                let first = known.next().unwrap_or_default();
                if known.any(|other| other != first) {
                    return Follows::Nothing;
                }
                // All that are known are alike.
                let at = pairs.iter().position(|&pair| Some(pair) == next);
                at.is_none_or(|at| first == is_reversed(at))
            }
        };
        match next {
            Some(pair) => Follows::Answer { pair, answer },
            // With nothing open, `answer` tells that the rule is broken.
            None if answer => Follows::Contradiction,
            None => Follows::Nothing,
        }
    }
}

/// What follows from a rule.
enum Follows {
    Nothing,
    Answer { pair: usize, answer: bool },
    Contradiction,
}

/// The state of a search.
pub(super) struct Search<'a> {
    rules: &'a [Rule],
    /// Numbers of the rules on each pair.
    rules_on: Vec<Vec<u32>>,
    answers: Vec<Option<bool>>,
    /// Pairs in the order in which they were answered.
    trail: Vec<usize>,
}

impl<'a> Search<'a> {
    /// Takes the rules on this number of pairs.
    pub(super) fn new(pairs: usize, rules: &'a [Rule]) -> Self {
        let mut rules_on = vec![Vec::new(); pairs];
        for (number, rule) in (0..).zip(rules) {
            for &pair in rule.pairs() {
                rules_on[pair].push(number);
            }
        }
        Self {
            rules,
            rules_on,
            answers: vec![None; pairs],
            trail: Vec::new(),
        }
    }

    /// Returns `true` if answers keep all rules. Takes what it looks at from `steps`, and returns `None` once they are used
    /// up.
    pub(super) fn has_solution(mut self, steps: &mut usize) -> Option<bool> {
        for rule in 0..self.rules.len() {
            let before = self.trail.len();
            if !self.keeps(rule) || !self.follow(before, steps)? {
                return Some(false);
            }
        }
        // Pairs that no rule connects are searched one after the other.
        for pair in 0..self.answers.len() {
            let part = self.part(pair);
            if !self.search(&part, steps)? {
                return Some(false);
            }
        }
        Some(true)
    }

    /// Returns the pairs without an answer that rules connect with this one, itself included; none if it has an answer.
    fn part(&self, pair: usize) -> Vec<usize> {
        if self.answers[pair].is_some() {
            return Vec::new();
        }
        let mut part = vec![pair];
        let mut is_in = vec![false; self.answers.len()];
        is_in[pair] = true;
        let mut at = 0;
        while let Some(&pair) = part.get(at) {
            at += 1;
            for &rule in &self.rules_on[pair] {
                for &other in self.rules[rule as usize].pairs() {
                    if self.answers[other].is_none() && !is_in[other] {
                        is_in[other] = true;
                        part.push(other);
                    }
                }
            }
        }
        part
    }

    /// Answers the pairs of a part, one after the other.
    fn search(&mut self, part: &[usize], steps: &mut usize) -> Option<bool> {
        // Lengths of the trail before each choice, the pair, and whether its other answer was tried.
        let mut choices: Vec<(usize, usize, bool)> = Vec::new();
        loop {
            let open = part.iter().find(|&&pair| self.answers[pair].is_none());
            let Some(&pair) = open else {
                return Some(true);
            };
            choices.push((self.trail.len(), pair, false));
            let mut is_kept = self.answer(pair, true, steps)?;
            while !is_kept {
                let Some((before, pair, is_last)) = choices.pop() else {
                    return Some(false);
                };
                self.undo(before);
                if !is_last {
                    choices.push((before, pair, true));
                    is_kept = self.answer(pair, false, steps)?;
                }
            }
        }
    }

    fn undo(&mut self, before: usize) {
        for pair in self.trail.drain(before..) {
            self.answers[pair] = None;
        }
    }

    /// Answers a pair, and all that follows. Returns `false` if that breaks a rule.
    fn answer(&mut self, pair: usize, answer: bool, steps: &mut usize) -> Option<bool> {
        let before = self.trail.len();
        self.set(pair, answer);
        self.follow(before, steps)
    }

    /// Answers all that follows from the answers after the first `at`. Returns `false` if they break a rule.
    fn follow(&mut self, mut at: usize, steps: &mut usize) -> Option<bool> {
        while let Some(&pair) = self.trail.get(at) {
            at += 1;
            for k in 0..self.rules_on[pair].len() {
                *steps = steps.checked_sub(1)?;
                if !self.keeps(self.rules_on[pair][k] as usize) {
                    return Some(false);
                }
            }
        }
        Some(true)
    }

    /// Answers what follows from one rule. Returns `false` if it is broken.
    fn keeps(&mut self, rule: usize) -> bool {
        match self.rules[rule].follows(&self.answers) {
            Follows::Nothing => {}
            Follows::Answer { pair, answer } => self.set(pair, answer),
            Follows::Contradiction => return false,
        }
        true
    }

    fn set(&mut self, pair: usize, answer: bool) {
        self.answers[pair] = Some(answer);
        self.trail.push(pair);
    }
}
