//! Catalogue data of PI's PICMA benders.
//!
//! Full differential drive: the outer electrodes are at 0 and 60 V and the centre electrode moves between them. It
//! drives both halves of the ceramic, so the capacitance is twice that of one half. Tolerances: +-20 %, thickness +-0.1
//! mm.
//!
//! A tip force F bends a cantilever by F L^3 / (3 E I), I = w t^3 / 12, and the blocking force compensates the free
//! displacement: together they give Young's modulus.
//!
//! Source: PI datasheet PL112-PL140, PICMA Bender, 31.07.2020. The density is that of PZT, not from the datasheet.

/// Density of the ceramic [kg/m^3].
pub(crate) const DENSITY: f64 = 7800.0;

/// One bender of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bender {
    /// Order number.
    pub name: &'static str,
    /// Free displacement at +-30 V, in one direction [m].
    pub displacement: f64,
    /// Blocking force [N].
    pub blocking_force: f64,
    /// Length of the ceramic [m].
    pub length: f64,
    /// Width [m].
    pub width: f64,
    /// Thickness [m].
    pub thickness: f64,
    /// Free length, outside the clamp [m].
    pub free_length: f64,
    /// Capacitance of both halves, the load of the driver [F].
    pub capacitance: f64,
    /// Resonance, clamped on one side, without load [Hz].
    pub resonance: f64,
}

/// PL112.10.
#[rustfmt::skip]
pub(crate) const PL112: Bender = Bender {
    name: "PL112.10", displacement: 100e-6, blocking_force: 2.1, length: 18e-3, width: 9.6e-3, thickness: 0.67e-3,
    free_length: 12e-3, capacitance: 2.2e-6, resonance: 1800.0,
};

/// PL122.10.
#[rustfmt::skip]
pub(crate) const PL122: Bender = Bender {
    name: "PL122.10", displacement: 310e-6, blocking_force: 1.25, length: 25e-3, width: 9.6e-3, thickness: 0.67e-3,
    free_length: 22e-3, capacitance: 5.0e-6, resonance: 600.0,
};

/// PL127.10.
#[rustfmt::skip]
pub(crate) const PL127: Bender = Bender {
    name: "PL127.10", displacement: 450e-6, blocking_force: 1.1, length: 31e-3, width: 9.6e-3, thickness: 0.67e-3,
    free_length: 27e-3, capacitance: 6.8e-6, resonance: 420.0,
};

/// PL128.10.
#[rustfmt::skip]
pub(crate) const PL128: Bender = Bender {
    name: "PL128.10", displacement: 450e-6, blocking_force: 0.55, length: 36e-3, width: 6.15e-3, thickness: 0.67e-3,
    free_length: 28e-3, capacitance: 2.4e-6, resonance: 360.0,
};

/// PL140.10.
#[rustfmt::skip]
pub(crate) const PL140: Bender = Bender {
    name: "PL140.10", displacement: 1000e-6, blocking_force: 0.5, length: 45e-3, width: 11e-3, thickness: 0.55e-3,
    free_length: 40e-3, capacitance: 8.2e-6, resonance: 160.0,
};

/// The five benders of the datasheet.
#[cfg(test)]
pub(super) static BENDERS: [Bender; 5] = [PL112, PL122, PL127, PL128, PL140];

impl Bender {
    /// Stiffness at the tip [N/m].
    pub(super) fn stiffness(&self) -> f64 {
        self.blocking_force / self.displacement
    }

    /// Young's modulus that gives the stiffness [Pa].
    pub(super) fn youngs_modulus(&self) -> f64 {
        let i = self.width * self.thickness.powi(3) / 12.0;
        self.stiffness() * self.free_length.powi(3) / (3.0 * i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_blocking_force_gives_the_modulus_of_a_piezo_ceramic() {
        assert_close(&[PL140.stiffness(), PL140.youngs_modulus()], &[500.0, 69.9e9], 1e-3, 0.0);
        for bender in &BENDERS {
            // PIC255: 1 / s11E = 62.1 GPa; the datasheet is +-20 % and the thickness, cubed, +-0.1 mm.
            assert_close(&[bender.youngs_modulus()], &[62.1e9], 0.2, 0.0);
            assert!(bender.free_length < bender.length && bender.width < bender.length, "{}", bender.name);
        }
    }
}
