//! What the machine that runs the tests can do.

/// Whether the steps of the swarm's cost are fused multiply-adds here.
pub(crate) fn fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::is_x86_feature_detected!("fma") && std::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return cfg!(target_arch = "aarch64");
}
