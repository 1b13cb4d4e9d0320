"""The model-free force-motion law: error manifolds, gains, torque."""
