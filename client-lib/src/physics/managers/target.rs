//! The target manager (F5).

/// Whom an object watches, and who watches it.
#[derive(Debug, Clone, Default)]
pub struct TargetManager {}
