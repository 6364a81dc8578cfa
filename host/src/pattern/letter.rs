//! The letters of edges: FOLD's `edges_assignment`.

/// FOLD assignment of an edge of a crease pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Letter {
    /// B: the border of the sheet.
    Boundary,
    /// M: folds away from the viewer, negative fold angle.
    Mountain,
    /// V: folds towards the viewer, positive fold angle.
    Valley,
    /// F: a crease mark that stays flat.
    Flat,
    /// U: a hinge that may turn either way.
    Unassigned,
    /// J: joins two parts of one panel and always stays flat.
    Join,
    /// J: a diagonal about which one panel bends, in a motion whose panels may bend. A file tells it from
    /// [`Join`](Self::Join) by its fold angles.
    Bend,
    /// C: a cut.
    Cut,
}

impl Letter {
    /// The letters of files with their codes.
    pub const ALL: [(char, Self); 7] = [
        ('B', Self::Boundary),
        ('M', Self::Mountain),
        ('V', Self::Valley),
        ('F', Self::Flat),
        ('U', Self::Unassigned),
        ('J', Self::Join),
        ('C', Self::Cut),
    ];

    /// Parses FOLD's code of a letter, capital or small. Returns `None` for any other text.
    #[must_use]
    pub fn from_code(code: &str) -> Option<Self> {
        let mut chars = code.chars();
        let code = chars.next()?.to_ascii_uppercase();
        let known = Self::ALL.iter().find(|(known, _)| *known == code);
        known.filter(|_| chars.next().is_none()).map(|l| l.1)
    }

    /// Returns FOLD's code of the letter.
    #[must_use]
    pub fn code(self) -> char {
        let written = if self == Self::Bend { Self::Join } else { self };
        let known = Self::ALL.iter().find(|(_, letter)| *letter == written);
        known.map_or('U', |l| l.0)
    }

    /// Returns the sign of the fold angle that the letter requires: 1 for valley, -1 for mountain, 0 for any other
    /// letter.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Valley => 1.0,
            Self::Mountain => -1.0,
            _ => 0.0,
        }
    }

    /// Exchanges mountain and valley, as for a sheet seen from its other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        match self {
            Self::Valley => Self::Mountain,
            Self::Mountain => Self::Valley,
            other => other,
        }
    }

    /// Returns `true` if an edge with this letter separates the faces on its two sides.
    #[must_use]
    pub fn parts(self) -> bool {
        matches!(self, Self::Boundary | Self::Cut)
    }

    /// Returns `true` if an edge with this letter between two faces is a hinge that may turn.
    #[must_use]
    pub fn is_hinge(self) -> bool {
        matches!(
            self,
            Self::Mountain | Self::Valley | Self::Unassigned | Self::Bend
        )
    }
}
