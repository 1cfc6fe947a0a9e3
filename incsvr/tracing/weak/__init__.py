"""The weak form: equations over blocks of a torque that is measured with noise, and free runs that prove them."""
