"""Claims, cases and figures of Hamidouche et al. 2019."""
