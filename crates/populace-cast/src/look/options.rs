//! Hair, hats, glasses and bags, which people wear on joints.

/// Hair cut, or a headscarf that hides the hair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hair {
    /// Short hair that leaves the ears and the nape free.
    Short,
    /// Short hair with a parting, combed to one side.
    SidePart,
    /// Receding hairline.
    Receding,
    /// Full, short curls.
    Curly,
    /// Hair with a fringe, down to the chin.
    Bob,
    /// Long hair over the ears, down to the shoulders.
    Long,
    /// Hair gathered in a knot at the back of the head.
    Bun,
    /// Hair gathered in a tail that hangs down at the back.
    Ponytail,
    /// A scarf around head, throat and neck, in the colour of accessories.
    Headscarf,
}

impl Hair {
    /// Returns how far the hair keeps a head off the ground, in an order without unit.
    pub(crate) fn bulk(self) -> u8 {
        match self {
            Self::Receding => 0,
            Self::Short => 1,
            Self::SidePart => 2,
            Self::Bob => 3,
            Self::Long => 4,
            Self::Headscarf => 5,
            Self::Curly => 6,
            Self::Ponytail => 7,
            Self::Bun => 8,
        }
    }
}

/// Hat, worn over flat hair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hat {
    /// Cap with a visor.
    Cap,
    /// Knitted hat with a cuff.
    Beanie,
    /// Hat with a brim and a band.
    SunHat,
}

/// Glasses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glasses {
    /// Round rims.
    Round,
    /// Broad rims.
    Square,
    /// Dark lenses.
    Sun,
}

/// Bag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bag {
    /// Backpack with two straps.
    Backpack,
    /// Bag at the left hip, with a strap over the right shoulder.
    Shoulder,
}

/// An option: a part that a member can hide or swap for another of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// Group `hair`, of which exactly one is worn.
    Hair(Hair),
    /// Group `hat`.
    Hat(Hat),
    /// Group `glasses`.
    Glasses(Glasses),
    /// Group `bag`.
    Bag(Bag),
}

impl Extra {
    /// Returns the option's group and its name in the group.
    pub(crate) fn names(self) -> [&'static str; 2] {
        let (group, name) = match self {
            Self::Hair(Hair::Short) => ("hair", "short"),
            Self::Hair(Hair::SidePart) => ("hair", "side_part"),
            Self::Hair(Hair::Receding) => ("hair", "receding"),
            Self::Hair(Hair::Curly) => ("hair", "curly"),
            Self::Hair(Hair::Bob) => ("hair", "bob"),
            Self::Hair(Hair::Long) => ("hair", "long"),
            Self::Hair(Hair::Bun) => ("hair", "bun"),
            Self::Hair(Hair::Ponytail) => ("hair", "ponytail"),
            Self::Hair(Hair::Headscarf) => ("hair", "headscarf"),
            Self::Hat(Hat::Cap) => ("hat", "cap"),
            Self::Hat(Hat::Beanie) => ("hat", "beanie"),
            Self::Hat(Hat::SunHat) => ("hat", "sun_hat"),
            Self::Glasses(Glasses::Round) => ("glasses", "round"),
            Self::Glasses(Glasses::Square) => ("glasses", "square"),
            Self::Glasses(Glasses::Sun) => ("glasses", "sun"),
            Self::Bag(Bag::Backpack) => ("bag", "backpack"),
            Self::Bag(Bag::Shoulder) => ("bag", "shoulder"),
        };
        [group, name]
    }

    /// Returns the name of the option's part, such as `Option:hair:bob`.
    #[must_use]
    pub fn part_name(self) -> String {
        let [group, name] = self.names();
        format!("{}{group}:{name}", crate::OPTION)
    }
}
