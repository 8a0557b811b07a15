//! Colours by role, the same in every figure, light and dark.
//!
//! The hues follow Okabe and Ito's set, which people with any colour vision can distinguish, darkened on paper and
//! lightened on black for a contrast of at least 3:1. Dashes, markers and the legend distinguish the curves as well.

use std::fmt::Write;

/// The role of a curve, which sets its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The branch of rising input.
    Ascending,
    /// The branch of falling input.
    Descending,
    /// Measurement.
    Measured,
    /// Model.
    Model,
    /// Something to compare with: a separating line, an optimum, a limit.
    Reference,
    /// Residual: measurement minus model.
    Residual,
    /// Background.
    Muted,
    /// First of several similar curves.
    Accent1,
    /// Second of several similar curves.
    Accent2,
    /// Third of several similar curves.
    Accent3,
    /// Fourth of several similar curves.
    Accent4,
    /// Fifth of several similar curves.
    Accent5,
}

/// A colour: its name in the style sheet, its value on paper and on black.
struct Colour {
    name: &'static str,
    light: &'static str,
    dark: &'static str,
}

const fn colour(name: &'static str, light: &'static str, dark: &'static str) -> Colour {
    Colour { name, light, dark }
}

/// One row per [`Role`], in the order of the enum: the number of its colour in plots, which is `--plot-N` of the style
/// sheet of pages, and the colour.
const ROLES: [(usize, Colour); 12] = [
    (1, colour("ascending", "#0072b2", "#5cb3f2")),
    (2, colour("descending", "#c8500a", "#ff9257")),
    (0, colour("measured", "#5b636d", "#a9b1bb")),
    (3, colour("model", "#00805b", "#3cc79b")),
    (6, colour("reference", "#1d2126", "#e9e6df")),
    (4, colour("residual", "#9c4a8c", "#dc96ce")),
    (7, colour("muted", "#aab0b7", "#616973")),
    (1, colour("accent1", "#0072b2", "#5cb3f2")),
    (2, colour("accent2", "#c8500a", "#ff9257")),
    (3, colour("accent3", "#00805b", "#3cc79b")),
    (4, colour("accent4", "#9c4a8c", "#dc96ce")),
    (5, colour("accent5", "#946500", "#e2b23f")),
];

/// Ground, text and lines of the figures and of the pages around them.
const GROUNDS: [Colour; 7] = [
    colour("paper", "#fdfcf9", "#14161a"),
    colour("raised", "#f5f2eb", "#1d2026"),
    colour("ink", "#1d2126", "#e9e6df"),
    colour("soft", "#565d66", "#a8adb5"),
    colour("axis", "#8b9199", "#747b85"),
    colour("grid", "#e6e3db", "#2a2e35"),
    colour("brass", "#8a5f14", "#d9ae5f"),
];

impl Role {
    /// The `i`-th of several similar curves, counted from 0; repeats after the fifth.
    pub fn accent(i: usize) -> Role {
        [Role::Accent1, Role::Accent2, Role::Accent3, Role::Accent4, Role::Accent5][i % 5]
    }

    /// Its name in the style sheet.
    pub(super) fn name(self) -> &'static str {
        ROLES[self as usize].1.name
    }

    /// The number of its colour in plots.
    pub(super) fn number(self) -> usize {
        ROLES[self as usize].0
    }

    /// Its colour on paper, for viewers without style sheets.
    pub(super) fn light(self) -> &'static str {
        ROLES[self as usize].1.light
    }
}

/// The light value of a ground colour, for viewers without style sheets.
pub(super) fn ground(name: &str) -> &'static str {
    GROUNDS.iter().find(|c| c.name == name).map_or("none", |c| c.light)
}

/// The colours as custom properties `--pz-…` of the root element.
///
/// Dark if the system asks for it; `data-theme="dark"` or `"light"` on the root element overrides; print is light.
pub(super) fn properties() -> String {
    let roles = || ROLES.iter().map(|(_, colour)| colour);
    let all = |value: fn(&Colour) -> &str| -> String {
        GROUNDS.iter().chain(roles()).map(|c| format!("--pz-{}:{};", c.name, value(c))).collect()
    };
    let (light, dark) = (all(|c| c.light), all(|c| c.dark));
    let mut css = format!(
        ":root{{color-scheme:light;{light}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}\n\
         @media screen{{:root[data-theme=dark]{{color-scheme:dark;{dark}}}}}\n"
    );
    for c in roles() {
        let _ = writeln!(css, ".pz-{0}{{--pz-c:var(--pz-{0})}}", c.name);
    }
    css
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(hex: &str) -> f64 {
        let channel = |i: usize| {
            let v = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).unwrap()) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn every_curve_stands_out_from_its_ground_in_light_and_dark() {
        for (_, c) in ROLES.iter().filter(|(_, c)| c.name != "muted") {
            assert!(contrast(c.light, GROUNDS[0].light) > 4.0, "{} on paper", c.name);
            assert!(contrast(c.dark, GROUNDS[0].dark) > 4.0, "{} on black", c.name);
        }
        for text in GROUNDS.iter().filter(|c| ["ink", "soft", "brass"].contains(&c.name)) {
            assert!(contrast(text.light, GROUNDS[1].light) > 4.5 && contrast(text.dark, GROUNDS[1].dark) > 4.5);
        }
    }

    #[test]
    fn the_page_has_the_colours_of_reports() {
        let style = include_str!("../../../../web/style.css");
        // Its panes are lighter than what is around them, in both themes.
        for (ground, light, dark) in [
            ("paper", "paper", "raised"),
            ("ground", "raised", "paper"),
            ("text", "ink", "ink"),
            ("quiet", "soft", "soft"),
            ("edge", "grid", "grid"),
            ("control", "axis", "axis"),
            ("accent", "brass", "brass"),
        ] {
            let of = |name: &str, value: fn(&Colour) -> &str| {
                let colour = GROUNDS.iter().find(|colour| colour.name == name).unwrap();
                style.matches(&format!("--{ground}: {};", value(colour))).count()
            };
            assert_eq!((of(light, |c| c.light), of(dark, |c| c.dark)), (1, 2), "{ground}");
        }
        let roles = [Role::Measured, Role::Accent1, Role::Accent2, Role::Accent3, Role::Accent4, Role::Accent5];
        for role in roles {
            let (_, Colour { light, dark, .. }) = ROLES[role as usize];
            let of = |colour: &str| style.matches(&format!("--plot-{}: {colour};", role.number())).count();
            assert_eq!((of(light), of(dark)), (1, 2), "{}", role.name());
        }
    }

    #[test]
    fn every_role_finds_its_own_row() {
        assert_eq!(Role::Ascending.name(), "ascending");
        assert_eq!(Role::Muted.name(), "muted");
        assert_eq!(Role::accent(4).name(), "accent5");
        assert_eq!(Role::accent(5), Role::Accent1);
    }
}
