"""Plant of the friction graph: braked wheels, their sensors and the truth, at 200 Hz"""
