"""What is concluded from all readings at once: attitude at every sample, errors and covariance."""
