//! piezosystem jena NV200/D Net over TCP: a controller that is simulated around a plant.

mod simulated;

pub(crate) use simulated::simulated;
